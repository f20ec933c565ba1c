#include "tumble/math/regression/lack_of_fit.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/square.hpp"
#include "tumble/math/vector3.hpp"
#include "tumble/reduce/linear/boundaries.hpp"
#include "tumble/reduce/linear/segment_means.hpp"
#include "tumble/reduce/linear/words.hpp"
#include "tumble/reduce/linear/work.hpp"

namespace tumble::linear {
namespace {

constexpr double least_error_freedom = 3.0;  ///< with fewer, F says nothing at p = 1e-5
constexpr double change_by_noise = 5.0;      ///< [sd] of a segment: a change by less is no finding, however significant
constexpr double beyond_stated = 5.0;        ///< [sd] as stated of an error of the rig, at least as stated

constexpr double rare = 1e-5;  ///< chance that a sound test gives a finding, of each kind

SegmentMeans resting_means(const Work& work) {
  std::vector<std::size_t> resting;
  for (std::size_t g = 0; g < work.solution.segments.size(); ++g)
    if (work.solution.segments[g].steady) resting.push_back(g);
  return segment_means(work, std::move(resting), work.solution.fit.slow_variance);
}

/// Which position each segment holds: equal numbers where the same is felt in one power-up.
std::vector<std::size_t> positions_of(const Work& work, const SegmentMeans& means) {
  std::vector<std::size_t> position;
  const auto& stretches = work.evidence.test.stretches;
  for (std::size_t a = 0; a < means.segments.size(); ++a) {
    std::size_t first = 0;
    for (; first < a; ++first) {
      const Felt &felt = work.solution.segments[means.segments[a]].felt,
                 &other = work.solution.segments[means.segments[first]].felt;
      if (stretches[means.segments[a]].start == stretches[means.segments[first]].start && is_same_input(felt, other))
        break;
    }
    position.push_back(first == a ? a : position[first]);
  }
  return position;
}

/// Positions against repeats, and repeats against positions.
void look_at_repeats(const Work& work, const std::string& role, const SegmentMeans& means, Solution& solution) {
  const auto fit = lack_of_fit(means.design, indicators(positions_of(work, means)), means.output, means.covariance);
  if (!(fit.freedom > 0.0 && fit.error_freedom > 0.0)) return;
  if (fit.error_freedom >= least_error_freedom && fit.probability < rare)
    solution.findings.push_back({Finding::Severity::warning,
                                 "positions_differ_more_than_repeats",
                                 {{"times", std::sqrt(fit.ratio)}, {"repeats", static_cast<int>(fit.error_freedom)}},
                                 role});
  const double inverse = 1.0 / std::max(fit.ratio, 1e-12);
  if (fit.freedom >= least_error_freedom && chance_of_ratio(inverse, fit.error_freedom, fit.freedom) < rare)
    solution.findings.push_back(
        {Finding::Severity::warning, "repeats_differ_more_than_positions", {{"times", std::sqrt(inverse)}}, role});
}

/// A drift in time that all positions share.
void look_at_time(const std::string& role, const SegmentMeans& means, Solution& solution) {
  const std::size_t n = means.segments.size();
  Matrix time(n, 1);
  for (std::size_t a = 0; a < n; ++a) time(a, 0) = means.time[a];
  const auto [first, last] = std::ranges::minmax(means.time);
  const auto fit = lack_of_fit(means.design, time, means.output, means.covariance);
  std::vector<double> noise;
  for (std::size_t a = 0; a < n; ++a) noise.push_back(std::sqrt(solution.fit.white_variance / means.duration[a]));
  const double change = fit.coefficient * (last - first);
  if (!(fit.error_freedom >= least_error_freedom) || fit.probability > rare ||
      std::abs(change) < change_by_noise * median(noise))
    return;
  solution.findings.push_back(
      {Finding::Severity::warning,
       "output_drifts_with_time",
       {{"times", std::abs(change) / median(noise)}, {"length", last - first, "s"}, {"ratio", fit.ratio}},
       role});
}

/// An error of the rig, beside the model.
struct Suspect {
  LackOfFit fit;
  std::string name;
  double sd = 0.0;  ///< of the coefficient by white noise
};

std::vector<Suspect> suspects(const Work& work, const SegmentMeans& means) {
  std::vector<double> variances;
  for (const double duration : means.duration) variances.push_back(work.solution.fit.white_variance / duration);
  const Matrix white = diagonal(variances);
  std::vector<Suspect> out;
  for (std::size_t k = 0; k < work.data.effects.size(); ++k) {
    const KnownEffect& effect = work.data.effects[k];
    if (effect.each_segment || effect.source == rounding_source) continue;
    const Matrix column = as_column(tumble::column(means.effects, k));
    const auto fit = lack_of_fit(means.design, column, means.output, means.covariance);
    if (!(fit.freedom > 0.0 && fit.error_freedom >= least_error_freedom)) continue;
    out.push_back({fit, effect.draws.size() == 1 ? effect.draws.front() : effect.source,
                   lack_of_fit(means.design, column, means.output, white).sd});
  }
  return out;
}

/// Errors of the rig that are far larger than stated. Of those that explain the segments almost alike, the one that
/// needs the least multiple of what is stated.
void look_at_errors(const Work& work, const std::string& role, const SegmentMeans& means, Solution& solution) {
  constexpr double alike = 0.8;  // of the greatest F
  const auto all = suspects(work, means);
  if (all.empty()) return;
  const auto ratio = [](const Suspect& suspect) { return suspect.fit.ratio; };
  const double greatest = std::ranges::max(all, {}, ratio).fit.ratio;
  const Suspect* worst = nullptr;
  for (const Suspect& suspect : all)
    if (suspect.fit.ratio >= alike * greatest &&
        (!worst || std::abs(suspect.fit.coefficient) < std::abs(worst->fit.coefficient)))
      worst = &suspect;
  if (worst->fit.probability * static_cast<double>(all.size()) > rare) return;
  // Beyond what was stated by itself, however little else scatters. Slow noise is no part of this: what the error does
  // seems to be such noise where it is not in the model.
  if (std::abs(worst->fit.coefficient) < beyond_stated * std::max(1.0, worst->sd)) return;
  solution.findings.push_back({Finding::Severity::error,
                               "rig_error_beyond_stated",
                               {{"error", worst->name}, {"times", std::abs(worst->fit.coefficient)}},
                               role});
}

/// A straight line through the averages of one segment.
struct Ramp {
  double slope = 0.0;    ///< [SI/s]
  double weight = 0.0;   ///< [s^3] sum of w (t - mean t)^2
  double squares = 0.0;  ///< [SI^2 s] of the averages about the line, weighted
  double count = 0.0;    ///< of averages
};

/// Given: averages [first, end) of one segment, and what is looked at in each [SI].
Ramp ramp_of(const Rows& rows, const std::vector<double>& values, std::size_t first, std::size_t end) {
  double w = 0.0, time = 0.0, output = 0.0;
  for (std::size_t i = first; i < end; ++i) {
    w += rows.weights[i];
    time += rows.weights[i] * rows.time[i];
    output += rows.weights[i] * values[i];
  }
  Ramp ramp{.count = static_cast<double>(end - first)};
  double product = 0.0;
  for (std::size_t i = first; i < end; ++i) {
    const double t = rows.time[i] - time / w, y = values[i] - output / w;
    ramp.weight += rows.weights[i] * t * t;
    product += rows.weights[i] * t * y;
    ramp.squares += rows.weights[i] * y * y;
  }
  if (!(ramp.weight > 0.0)) return {};
  ramp.slope = product / ramp.weight;
  ramp.squares = std::max(0.0, ramp.squares - ramp.slope * product);
  return ramp;
}

/// The lines of the segments at rest with three averages and more.
std::vector<Ramp> ramps_within(const Work& work) {
  std::vector<Ramp> ramps;
  const auto& segment = work.rows.segment;
  for (std::size_t first = 0, end = 0; first < segment.size(); first = end) {
    while (end < segment.size() && segment[end] == segment[first]) ++end;
    if (!work.solution.segments[segment[first]].steady || end - first < 3) continue;
    const Ramp ramp = ramp_of(work.rows, work.data.observations, first, end);
    if (ramp.weight > 0.0) ramps.push_back(ramp);
  }
  return ramps;
}

/// The slope within the segments that all share, by its scatter from segment to segment; where the scatter about the
/// lines explains that, by both together, so that few segments suffice. Slow noise within few segments may seem to
/// agree with the scatter about the lines: the slope must be unlikely by its own scatter too.
void look_within(const Work& work, const std::string& role, Solution& solution) {
  const auto ramps = ramps_within(work);
  if (ramps.size() < 3) return;
  const double n = static_cast<double>(ramps.size());
  double weight = 0.0, mean = 0.0, between = 0.0, within = 0.0, averages = 0.0;
  for (const Ramp& ramp : ramps) weight += ramp.weight, mean += ramp.weight * ramp.slope;
  mean /= weight;
  for (const Ramp& ramp : ramps) {
    between += ramp.weight * square(ramp.slope - mean);
    within += ramp.squares;
    averages += ramp.count;
  }
  constexpr double alike = 0.1, unlikely = 0.01;
  const double freedom = n - 1.0, about_lines = averages - 2.0 * n, shared = square(mean) * weight;
  if (!(between > 0.0)) return;
  double ratio = shared * freedom / between, chance = chance_of_ratio(ratio, 1.0, freedom);
  if (chance < unlikely && chance_of_ratio(between / freedom / (within / about_lines), freedom, about_lines) > alike) {
    ratio = shared * (freedom + about_lines) / (between + within);
    chance = chance_of_ratio(ratio, 1.0, freedom + about_lines);
  }
  if (chance > rare) return;
  solution.findings.push_back({Finding::Severity::warning,
                               "output_drifts_within_segments",
                               {{"times", std::sqrt(ratio)}, {"segments", ramps.size()}},
                               role});
}

/// How a segment follows the one before.
struct Follower {
  Ramp ramp;          ///< of what the model leaves
  double step = 0.0;  ///< [SI] between the means of the two
  double duration = 0.0;
};

/// The segments of three averages and more, moving or not, that follow another without a pause.
std::vector<Follower> followers(const Work& work) {
  std::vector<double> left;
  for (std::size_t i = 0; i < work.data.observations.size(); ++i)
    left.push_back(work.data.observations[i] - work.solution.fit.fitted[i]);
  const auto& segment = work.rows.segment;
  const auto& test = work.evidence.test;
  std::vector<Follower> out;
  for (std::size_t first = 0, end = 0; first < segment.size(); first = end) {
    const std::size_t g = segment[first];
    while (end < segment.size() && segment[end] == g) ++end;
    if (g == 0 || end - first < 3 || !adjoin(test, test.stretches[g - 1], test.stretches[g])) continue;
    const auto &now = work.solution.segments[g], &before = work.solution.segments[g - 1];
    const Ramp ramp = ramp_of(work.rows, left, first, end);
    if (ramp.weight > 0.0) out.push_back({ramp, now.measured - before.measured, now.duration});
  }
  return out;
}

/// A change within the segments in proportion to the step that led to them, by its scatter from segment to segment.
void look_at_settling(const Work& work, const std::string& role, Solution& solution) {
  constexpr double negligible = 1e-9;
  const auto all = followers(work);
  const double freedom = static_cast<double>(all.size()) - 1.0;
  double squares = 0.0, product = 0.0, total = 0.0, duration = 0.0;
  for (const Follower& one : all) {
    squares += one.ramp.weight * square(one.step);
    product += one.ramp.weight * one.step * one.ramp.slope;
    total += one.ramp.weight * square(one.ramp.slope);
    duration += one.duration / static_cast<double>(all.size());
  }
  if (!(freedom >= least_error_freedom && squares > 0.0)) return;
  const double slope = product / squares, share = std::abs(slope) * duration;
  const double ratio = slope * product * freedom / std::max(total - slope * product, 0.0);
  if (share < negligible || chance_of_ratio(ratio, 1.0, freedom) > rare) return;
  solution.findings.push_back({Finding::Severity::warning,
                               "segments_settle",
                               {{"share", share, "%"}, {"times", std::sqrt(ratio)}, {"segments", all.size()}},
                               role});
}

}  // namespace

void warn_of_lack_of_fit(const Problem& problem, Work& work) {
  Solution& solution = work.solution;
  const SegmentMeans means = resting_means(work);
  look_within(work, problem.role, solution);
  if (!misplaced(solution.findings)) look_at_settling(work, problem.role, solution);
  if (means.segments.size() < work.data.design.columns + 3) return;
  look_at_repeats(work, problem.role, means, solution);
  look_at_time(problem.role, means, solution);
  look_at_errors(work, problem.role, means, solution);
}

}  // namespace tumble::linear
