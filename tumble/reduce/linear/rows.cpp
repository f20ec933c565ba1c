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
constexpr double within_end = 1e-6;    ///< of a step by which the last point stays before the end of its segment

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

/// One output in a stretch.
struct Summed {
  const Problem& problem;
  const Stretch& stretch;
  Sums& sums;
  std::vector<Response> responses = {};  ///< of each series
};

/// At rest, or turning evenly about the vertical: one instant is enough, except for the time since power-on.
void sum_steady(const PowerUp& power_up, const Summed& output) {
  const auto& [problem, stretch, sums, responses] = output;
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
  constexpr double most_with_response = 0.02, most_turned = 0.1;  // [rad]
  const double most = problem.response ? most_with_response : most_turned;
  const double steps = std::ceil(two_pi * quickest(segment) * stretch.step / most);
  return static_cast<std::size_t>(std::max<double>(problem.oversampling, std::min(most_steps, steps)));
}

/// Some samples of a moving stretch, as the rig was asked at points within each, and before and after them.
struct Moved {
  std::span<const Felt> points;
  std::vector<StepCourse> courses;
  std::size_t front = 0;              ///< points before the first sample
  std::size_t samples = 0, fine = 0;  ///< points in a sample
  std::size_t done = 0, before = 0;   ///< samples before these; those before the first that counts
};

/// Adds what one output shows in these samples, through its response where there is one.
void add_samples(const Moved& moved, std::size_t per_block, Summed& output, std::vector<double>& middles,
                 std::vector<double>& values) {
  const auto block = std::span(values).first(moved.samples * moved.fine);
  for (std::size_t s = 0; s < output.sums.series.columns; ++s) {
    for (std::size_t k = 0; k < moved.points.size(); ++k) middles[k] = evaluate(output.problem, s, moved.points[k]);
    means_from_middles(std::span(middles).first(moved.points.size()), moved.courses, moved.front, block);
    if (output.responses[s]) output.responses[s](block);
    for (std::size_t i = moved.done < moved.before ? moved.before - moved.done : 0; i < moved.samples; ++i) {
      const std::size_t sample = moved.done + i - moved.before;
      if (!present(output.stretch, sample)) continue;
      double mean = 0.0;
      for (std::size_t k = 0; k < moved.fine; ++k) mean += block[i * moved.fine + k];
      output.sums.series(sample / per_block, s) += mean / static_cast<double>(moved.fine);
    }
  }
}

/// How what is felt goes through each of these points of a segment.
std::vector<StepCourse> courses_in(const Segment& segment, std::span<const Felt> points) {
  return goes_on(segment) ? courses_of(points) : std::vector<StepCourse>(points.size(), StepCourse::kinked);
}

/// Makes the responses of outputs that were read together, for points `step` [s] apart: the samples that run through
/// them before the first that counts.
std::size_t start_responses(double step, std::span<Summed> outputs) {
  for (auto& output : outputs) output.responses.resize(output.sums.series.columns);
  Summed& first = outputs.front();
  if (!first.problem.response) return 0;
  for (auto& response : first.responses) response = first.problem.response(step);
  return static_cast<std::size_t>(std::min(run_in, first.stretch.first) / first.stretch.step);
}

void set_felt(const Vector3& force, const Vector3& rate, const Extent& extent, Sums& sums) {
  sums.extent = extent;
  sums.felt.specific_force = force;
  sums.felt.rate = rate;
}

/// The points of a moving stretch, one block of points after the other, each the mean over its step. The outputs were
/// read together.
void sum_moving(const PowerUp& power_up, const Blocking& blocking, std::span<Summed> outputs) {
  const Stretch& stretch = outputs.front().stretch;
  const Problem& problem = outputs.front().problem;
  const std::size_t fine = steps_of_sample(power_up.rig.segments[stretch.segment], stretch, problem);
  const double step = stretch.step / static_cast<double>(fine);  // recordings of one plan may differ in rate
  const std::size_t before = start_responses(step, outputs);
  const double begin = stretch.first - static_cast<double>(before) * stretch.step + 0.5 * step;
  const double start = power_up.begins[stretch.segment], end = power_up.begins[stretch.segment + 1];
  const std::size_t all = before + stretch.samples, samples_at_once = std::max<std::size_t>(1, at_once / fine);
  std::vector<Felt> felt(samples_at_once * fine + 2 * step_margin);
  std::vector<double> middles(felt.size()), values(felt.size());
  Vector3 force, rate;
  Extent extent;
  for (std::size_t done = 0; done < all; done += samples_at_once) {
    const std::size_t samples = std::min(samples_at_once, all - done), steps = samples * fine;
    const double first = begin + static_cast<double>(done) * stretch.step;
    const auto fit = [&](double room) {
      return static_cast<std::size_t>(std::clamp(room / step, 0.0, static_cast<double>(step_margin)));
    };
    // a point at the very end belongs to the next segment, which may begin elsewhere
    const std::size_t front = fit(first - start),
                      back = fit(end - first - (static_cast<double>(steps - 1) + within_end) * step);
    const auto points = std::span(felt).first(front + steps + back);
    power_up.reference.felt(first - static_cast<double>(front) * step, step, points);
    const Moved moved{points, courses_in(power_up.rig.segments[stretch.segment], points), front, samples, fine, done,
                      before};
    for (auto& output : outputs) add_samples(moved, blocking.per_block, output, middles, values);
    for (const Felt& point : points.subspan(front, steps)) {
      force = force + point.specific_force;
      rate = rate + point.rate;
      extent.add(point);
    }
  }
  const double share = 1.0 / static_cast<double>(all * fine);
  for (auto& output : outputs) set_felt(share * force, share * rate, extent, output.sums);
}

/// A move used whole: one block.
void sum_whole(const PowerUp& power_up, const Blocking& blocking, const Summed& output) {
  const auto& [problem, stretch, sums, responses] = output;
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

/// The sums of stretch g, of each output that was read together with the first one.
std::vector<Sums> sums_of(std::span<const Read> outputs, std::size_t g) {
  const Evidences& evidence = outputs.front().evidence;
  const Blocking& blocking = evidence.blocking[g];
  const PowerUp& power_up = evidence.test.power_ups[evidence.test.stretches[g].power_up];
  std::vector<Sums> sums;
  for (const auto& output : outputs)
    sums.emplace_back(output.evidence.test.stretches[g], blocking.per_block, output.problem.columns.size());
  std::vector<Summed> summed;
  for (std::size_t k = 0; k < sums.size(); ++k)
    summed.push_back({outputs[k].problem, outputs[k].evidence.test.stretches[g], sums[k]});
  if (!evidence.test.stretches[g].steady && blocking.instants.empty())
    sum_moving(power_up, blocking, summed);
  else
    for (const auto& output : summed)
      output.stretch.steady ? sum_steady(power_up, output) : sum_whole(power_up, blocking, output);
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

bool alike(const Segment& a, const Segment& b) {
  return a.label == b.label && a.run == b.run && a.duration == b.duration;
}

/// Whether the rig did the same in two power-ups, and is asked at the same rate.
bool alike(const PowerUp& a, const PowerUp& b) {
  const auto same = [](const Segment& x, const Segment& y) { return alike(x, y); };
  return a.plan == b.plan && a.plan_number == b.plan_number && a.step == b.step && a.offset == b.offset &&
         a.begins == b.begins && a.rig.rate == b.rig.rate && std::ranges::equal(a.rig.segments, b.rig.segments, same);
}

bool alike(const Stretch& a, const Stretch& b) {
  return a.power_up == b.power_up && a.segment == b.segment && a.start == b.start && a.repetition == b.repetition &&
         a.run == b.run && a.label == b.label && a.first == b.first && a.step == b.step && a.samples == b.samples &&
         a.steady == b.steady;
}

bool alike(const Blocking& a, const Blocking& b) {
  return a.even == b.even && a.per_block == b.per_block && a.instants.time == b.instants.time &&
         a.instants.share == b.instants.share;
}

/// Of each stretch the first one with the same sums, for all outputs that were read together.
std::vector<std::size_t> same_sums(std::span<const Read> outputs) {
  auto first = first_alike(outputs.front().evidence.test);
  const auto& blocking = outputs.front().evidence.blocking;
  for (std::size_t g = 0; g < first.size(); ++g) {
    const auto measured = [g](const Read& output) { return !output.evidence.test.stretches[g].values.empty(); };
    if (std::ranges::any_of(outputs, measured) || !alike(blocking[first[g]], blocking[g])) first[g] = g;
  }
  return first;
}

/// Given     parts   of each stretch, the sums of the outputs that were read together; this one has number `number`
Rows rows_of_sums(const Read& output, const std::vector<std::vector<Sums>>& parts, std::size_t number) {
  const auto& [evidence, problem] = output;
  Rows rows;
  Extent extent;
  std::size_t count = 0;
  for (const auto& part : parts)
    count += static_cast<std::size_t>(std::ranges::count_if(part[number].count, [](double c) { return c > 0.0; }));
  rows.design = Matrix(count, problem.columns.size());
  for (std::size_t g = 0; g < parts.size(); ++g) {
    const Stretch& stretch = evidence.test.stretches[g];
    const Sums& sums = parts[g][number];
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

}  // namespace

bool present(const Stretch& stretch, std::size_t sample) {
  return stretch.values.empty() || !std::isnan(stretch.values[sample]);
}

bool read_together(const Read& a, const Read& b) {
  const auto same = [](const auto& x, const auto& y) { return alike(x, y); };
  return !a.problem.response && !b.problem.response && a.problem.oversampling == b.problem.oversampling &&
         std::ranges::equal(a.evidence.test.power_ups, b.evidence.test.power_ups, same) &&
         std::ranges::equal(a.evidence.test.stretches, b.evidence.test.stretches, same) &&
         std::ranges::equal(a.evidence.blocking, b.evidence.blocking, same);
}

std::vector<std::vector<std::size_t>> groups_of(std::size_t outputs,
                                                const std::function<bool(std::size_t, std::size_t)>& together) {
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t k = 0; k < outputs; ++k) {
    const auto own = std::ranges::find_if(groups, [&](const auto& group) { return together(group.front(), k); });
    if (own == groups.end())
      groups.push_back({k});
    else
      own->push_back(k);
  }
  return groups;
}

std::vector<Rows> rows_of(std::span<const Read> outputs) {
  std::vector<Rows> rows(outputs.size());
  const auto together = [&](std::size_t a, std::size_t b) { return read_together(outputs[a], outputs[b]); };
  for (const auto& group : groups_of(outputs.size(), together)) {
    std::vector<Read> read;
    for (const std::size_t k : group) read.push_back(outputs[k]);
    std::vector<std::vector<Sums>> parts(read.front().evidence.test.stretches.size());
    const auto first = same_sums(read);
    parallel_for(parts.size(), [&](std::size_t g) {
      if (first[g] == g) parts[g] = sums_of(read, g);
    });
    for (std::size_t g = 0; g < parts.size(); ++g)
      if (first[g] != g) parts[g] = parts[first[g]];
    for (std::size_t i = 0; i < group.size(); ++i) rows[group[i]] = rows_of_sums(read[i], parts, i);
  }
  return rows;
}

Rows rows_of(const Evidences& evidence, const Problem& problem) {
  const Read output{evidence, problem};
  return std::move(rows_of(std::span(&output, 1)).front());
}

}  // namespace tumble::linear
