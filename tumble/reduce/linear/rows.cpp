#include "tumble/reduce/linear/rows.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/parallel.hpp"
#include "tumble/math/step_means.hpp"
#include "tumble/rigs/felt_courses.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::linear {
namespace {

constexpr std::size_t at_once = 2048;  ///< points at which a moving rig is asked in one go
constexpr double run_in = 2.0;         ///< [s] that a response runs before the first sample used

std::size_t count_of_blocks(const Stretch& stretch, std::size_t per_block) {
  return (stretch.samples + per_block - 1) / per_block;
}

/// The greatest of what is felt, along any axis.
struct Extent {
  double rate = 0.0, acceleration = 0.0, force = 0.0;

  void add(const Felt& felt) {
    const auto most = [](Vector3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); };
    rate = std::max(rate, most(felt.rate));
    acceleration = std::max(acceleration, most(felt.angular_acceleration));
    force = std::max(force, most(felt.specific_force));
  }
  void add(const Extent& other) {
    rate = std::max(rate, other.rate);
    acceleration = std::max(acceleration, other.acceleration);
    force = std::max(force, other.force);
  }
};

/// Sums over the samples of each block of one stretch. Series 0 is the input, the others are the columns.
struct Sums {
  Sums(const Stretch& stretch, std::size_t per_block, std::size_t columns)
      : series(count_of_blocks(stretch, per_block), columns + 1),
        output(series.rows, 0.0),
        time(series.rows, 0.0),
        count(series.rows, 0.0) {
    for (std::size_t i = 0; i < stretch.samples; ++i) {
      if (!present(stretch, i)) continue;
      const std::size_t block = i / per_block;
      count[block] += 1.0;
      time[block] += stretch.first + (static_cast<double>(i) + 0.5) * stretch.step;
      if (!stretch.values.empty()) output[block] += stretch.values[i];
    }
  }

  Matrix series;
  std::vector<double> output, time, count;
  Felt felt;  ///< mean
  Extent extent;
};

double evaluate(const Problem& problem, std::size_t series, const Felt& felt) {
  if (series > 0) return problem.columns[series - 1].regressor(felt);
  return problem.input ? problem.input(felt) : 0.0;
}

/// At rest, or turning evenly about the vertical: one instant is enough, except for the time since power-on.
void sum_steady(const PowerUp& power_up, const Stretch& stretch, const Blocking&, const Problem& problem, Sums& sums) {
  Felt felt;
  power_up.reference.felt(stretch.first + 0.5 * stretch.step, stretch.step, std::span(&felt, 1));
  sums.felt = felt;
  sums.extent.add(felt);
  for (std::size_t b = 0; b < sums.count.size(); ++b) {
    if (!(sums.count[b] > 0.0)) continue;
    felt.since_power_on = sums.time[b] / sums.count[b];
    for (std::size_t s = 0; s < sums.series.columns; ++s)
      sums.series(b, s) = sums.count[b] * evaluate(problem, s, felt);
  }
}

/// Steps of a sample at which the rig is asked: as many as the problem wants, and so many that what is felt turns by no
/// more than 0.1 rad in one, or 0.02 rad where a response follows, which is solved for parabolas through three steps.
std::size_t steps_of_sample(const Segment& segment, const Stretch& stretch, const Problem& problem) {
  constexpr double most_steps = 64.0;
  const double most = problem.response ? 0.02 : 0.1;
  const double steps = std::ceil(two_pi * quickest(segment) * stretch.step / most);
  return static_cast<std::size_t>(std::max<double>(problem.oversampling, std::min(most_steps, steps)));
}

/// The points of a moving stretch, one block of points after the other, each the mean over its step, through the
/// response where there is one.
void sum_moving(const PowerUp& power_up, const Stretch& stretch, const Blocking& blocking, const Problem& problem,
                Sums& sums) {
  const std::size_t fine = steps_of_sample(power_up.rig.segments[stretch.segment], stretch, problem);
  const double step = stretch.step / static_cast<double>(fine);  // recordings of one plan may differ in rate
  std::size_t before = 0;  // samples run through the response before the first that counts
  std::vector<Response> responses(sums.series.columns);
  if (problem.response) {
    before = static_cast<std::size_t>(std::min(run_in, stretch.first) / stretch.step);
    for (auto& response : responses) response = problem.response(step);
  }
  const double begin = stretch.first - static_cast<double>(before) * stretch.step + 0.5 * step;
  const double start = power_up.begins[stretch.segment], end = power_up.begins[stretch.segment + 1];
  const std::size_t all = before + stretch.samples, samples_at_once = std::max<std::size_t>(1, at_once / fine);
  std::vector<Felt> felt(samples_at_once * fine + 2 * step_margin);
  std::vector<double> middles(felt.size()), values(felt.size());
  Vector3 force, rate;
  for (std::size_t done = 0; done < all; done += samples_at_once) {
    const std::size_t samples = std::min(samples_at_once, all - done), steps = samples * fine;
    const double first = begin + static_cast<double>(done) * stretch.step;
    const auto fit = [&](double room) {
      return static_cast<std::size_t>(std::clamp(room / step, 0.0, static_cast<double>(step_margin)));
    };
    const std::size_t front = fit(first - start), back = fit(end - first - static_cast<double>(steps - 1) * step);
    const auto points = std::span(felt).first(front + steps + back);
    power_up.reference.felt(first - static_cast<double>(front) * step, step, points);
    const auto courses = goes_on(power_up.rig.segments[stretch.segment])
                             ? courses_of(std::span<const Felt>(points))
                             : std::vector<StepCourse>(points.size(), StepCourse::kinked);
    for (std::size_t s = 0; s < sums.series.columns; ++s) {
      for (std::size_t k = 0; k < points.size(); ++k) middles[k] = evaluate(problem, s, points[k]);
      const auto block = std::span(values).first(steps);
      means_from_middles(std::span(middles).first(points.size()), courses, front, block);
      if (responses[s]) responses[s](block);
      for (std::size_t i = done < before ? before - done : 0; i < samples; ++i) {
        const std::size_t sample = done + i - before;
        if (!present(stretch, sample)) continue;
        double mean = 0.0;
        for (std::size_t k = 0; k < fine; ++k) mean += block[i * fine + k];
        sums.series(sample / blocking.per_block, s) += mean / static_cast<double>(fine);
      }
    }
    for (const Felt& point : points.subspan(front, steps)) {
      force = force + point.specific_force;
      rate = rate + point.rate;
      sums.extent.add(point);
    }
  }
  const double share = 1.0 / static_cast<double>(all * fine);
  sums.felt.specific_force = share * force;
  sums.felt.rate = share * rate;
}

/// A move used whole: one block.
void sum_whole(const PowerUp& power_up, const Stretch& stretch, const Blocking& blocking, const Problem& problem,
               Sums& sums) {
  const double count = sums.count.front();
  for (std::size_t k = 0; k < blocking.instants.time.size(); ++k) {
    Felt felt;
    power_up.reference.felt(blocking.instants.time[k], stretch.step, std::span(&felt, 1));
    const double share = blocking.instants.share[k];
    for (std::size_t s = 0; s < sums.series.columns; ++s)
      sums.series(0, s) += count * share * evaluate(problem, s, felt);
    sums.felt.specific_force = sums.felt.specific_force + share * felt.specific_force;
    sums.felt.rate = sums.felt.rate + share * felt.rate;
    sums.extent.add(felt);
  }
}

Sums sums_of(const Evidences& evidence, std::size_t g, const Problem& problem) {
  const Stretch& stretch = evidence.test.stretches[g];
  const Blocking& blocking = evidence.blocking[g];
  Sums sums(stretch, blocking.per_block, problem.columns.size());
  (stretch.steady ? sum_steady
   : blocking.instants.empty()
       ? sum_moving
       : sum_whole)(evidence.test.power_ups[stretch.power_up], stretch, blocking, problem, sums);
  return sums;
}

SegmentSummary summary_of(const Stretch& stretch, const Sums& sums) {
  SegmentSummary summary{.label = stretch.label, .run = stretch.run, .begin = stretch.first, .steady = stretch.steady};
  summary.felt = sums.felt;
  double count = 0.0, output = 0.0;
  for (std::size_t b = 0; b < sums.count.size(); ++b) {
    count += sums.count[b];
    output += sums.output[b];
  }
  summary.duration = count * stretch.step;
  summary.measured = stretch.values.empty() ? std::nan("") : output / count;
  return summary;
}

/// The columns where all that is felt is at its greatest along all axes at once.
std::vector<double> natural_sizes(const Extent& extent, const Felt& typical, const Problem& problem) {
  Felt felt = typical;
  felt.rate = {extent.rate, extent.rate, extent.rate};
  felt.angular_acceleration = {extent.acceleration, extent.acceleration, extent.acceleration};
  felt.specific_force = {extent.force, extent.force, extent.force};
  std::vector<double> sizes;
  for (const auto& column : problem.columns) sizes.push_back(std::abs(column.regressor(felt)));
  return sizes;
}

}  // namespace

bool present(const Stretch& stretch, std::size_t sample) {
  return stretch.values.empty() || !std::isnan(stretch.values[sample]);
}

Rows rows_of(const Evidences& evidence, const Problem& problem) {
  std::vector<std::vector<Sums>> parts(evidence.test.stretches.size());
  parallel_for(parts.size(), [&](std::size_t g) { parts[g].push_back(sums_of(evidence, g, problem)); });
  Rows rows;
  Extent extent;
  std::size_t count = 0;
  for (const auto& part : parts)
    count += static_cast<std::size_t>(std::ranges::count_if(part[0].count, [](double c) { return c > 0.0; }));
  rows.design = Matrix(count, problem.columns.size());
  for (std::size_t g = 0; g < parts.size(); ++g) {
    const Stretch& stretch = evidence.test.stretches[g];
    const Sums& sums = parts[g][0];
    extent.add(sums.extent);
    rows.segments.push_back(summary_of(stretch, sums));
    for (std::size_t b = 0; b < sums.count.size(); ++b) {
      const double n = sums.count[b];
      if (!(n > 0.0)) continue;
      for (std::size_t j = 0; j < problem.columns.size(); ++j)
        rows.design(rows.weights.size(), j) = sums.series(b, j + 1) / n;
      rows.input.push_back(sums.series(b, 0) / n);
      if (!stretch.values.empty()) rows.output.push_back(sums.output[b] / n);
      rows.weights.push_back(n * stretch.step);
      rows.time.push_back(sums.time[b] / n);
      rows.segment.push_back(g);
      rows.block.push_back(b);
    }
  }
  rows.natural = natural_sizes(extent, rows.segments.front().felt, problem);
  return rows;
}

}  // namespace tumble::linear
