#include "tumble/reduce/linear/rest_noise.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tumble/math/median.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/math/square.hpp"
#include "tumble/reduce/linear/boundaries.hpp"
#include "tumble/reduce/linear/work.hpp"

namespace tumble::linear {
namespace {

constexpr double begins_by_chance = 1e-4;  ///< [1] over all segments of a sound test
/// [1] of the variance at rest: a rig that turns shakes the instrument a little, and twice the noise doubles the intervals.
constexpr double motion_over_rest = 4.0;
constexpr double least_freedom_of_noise = 8.0;  ///< with fewer, F says nothing at such p
/// [1] of the usual variance, and of what one in a thousand reaches with its degrees of freedom: such a segment is no noise.
constexpr double far_noisier = 10.0;

/// Weighted squares of some rows about their mean.
struct RowScatter {
  double weight = 0.0, mean = 0.0, squares = 0.0, count = 0.0;

  void add(double w, double value) {
    weight += w;
    const double off = value - mean;
    mean += off * w / weight;
    squares += w * off * (value - mean);
    ++count;
  }
  double freedom() const { return std::max(0.0, count - 1.0); }
};

/// The rows of one segment, of what the fit leaves.
struct SegmentRows {
  std::size_t segment = 0, first = 0, end = 0;
};

std::vector<SegmentRows> rows_by_segment(const Rows& rows) {
  std::vector<SegmentRows> all;
  for (std::size_t first = 0, end = 0; first < rows.segment.size(); first = end) {
    while (end < rows.segment.size() && rows.segment[end] == rows.segment[first]) ++end;
    all.push_back({rows.segment[first], first, end});
  }
  return all;
}

double left_in(const Work& work, std::size_t row) {
  return work.data.observations[row] - work.solution.fit.fitted[row];
}

RowScatter scatter_of(const Work& work, std::size_t first, std::size_t end) {
  RowScatter scatter;
  for (std::size_t i = first; i < end; ++i) scatter.add(work.rows.weights[i], left_in(work, i));
  return scatter;
}

/// A variance [SI^2 s] with its degrees of freedom.
struct Noise {
  double variance = 0.0, freedom = 0.0;
};

/// [1] of the true variance: this quantile of one with so many degrees of freedom.
double shown_by(double quantile, double freedom) { return chi_square_quantile(quantile, freedom) / freedom; }

/// Of all scatters but those far noisier than usual. Two averages show a hundredth of the variance or seven times of it by
/// chance: the usual variance is the median of them, each over the median of its own distribution, and a scatter is cut
/// off only where its own degrees of freedom do not explain it. Else the noise of short segments comes out too small.
Noise pooled(const std::vector<RowScatter>& scatters) {
  constexpr double middle = 0.5;
  std::vector<double> variances;
  for (const RowScatter& one : scatters)
    if (one.freedom() > 0.0) variances.push_back(one.squares / one.freedom() / shown_by(middle, one.freedom()));
  if (variances.empty()) return {};
  const double usual = median(variances);
  Noise noise;
  for (const RowScatter& one : scatters) {
    const double freedom = one.freedom();
    if (!(freedom > 0.0) || one.squares > far_noisier * usual * shown_by(exceeded_in_1000, freedom) * freedom) continue;
    noise.variance += one.squares;
    noise.freedom += freedom;
  }
  if (noise.freedom > 0.0) noise.variance /= noise.freedom;
  return noise;
}

}  // namespace

void warn_of_motion(const Problem& problem, Work& work) {
  std::vector<RowScatter> rest;
  double freedom = -static_cast<double>(work.data.design.columns), resting = 0.0, largest = 0.0;
  for (const auto& [segment, first, end] : rows_by_segment(work.rows)) {
    freedom += static_cast<double>(end - first) - 1.0;
    largest = std::max(largest, std::abs(work.solution.segments[segment].predicted));
    if (!work.evidence.uniform(segment)) continue;
    rest.push_back(scatter_of(work, first, end));
    resting += rest.back().freedom();
  }
  const Noise at_rest = pooled(rest);
  const double moving = freedom - resting;
  if (at_rest.freedom < least_freedom_of_noise || moving < least_freedom_of_noise) return;
  // the white noise of the fit is that of both, without what the known errors of the rig do within the segments
  const double in_motion = (work.solution.fit.white_variance * freedom - at_rest.variance * resting) / moving;
  const double ratio = in_motion / at_rest.variance;
  if (!(ratio > motion_over_rest) || std::sqrt(in_motion / work.rows.weights.front()) < rounding_share * largest)
    return;
  if (chance_of_ratio(ratio, moving, at_rest.freedom) > begins_by_chance) return;
  work.solution.findings.push_back(
      {Finding::Severity::warning, "motion_differs_from_model", {{"times", std::sqrt(ratio)}}, problem.role});
}

void warn_of_begins(const Problem& problem, Work& work) {
  constexpr std::size_t fewest = 4;  // averages: a begin, something between, and two at the end
  const auto all = rows_by_segment(work.rows);
  std::vector<SegmentRows> rests;
  std::vector<RowScatter> ends;
  double largest = 0.0;
  for (const SegmentRows& one : all) {
    largest = std::max(largest, std::abs(work.solution.segments[one.segment].predicted));
    if (one.end - one.first < fewest || !work.evidence.uniform(one.segment)) continue;
    rests.push_back(one);
    ends.push_back(scatter_of(work, one.first + (one.end - one.first) / 2, one.end));
  }
  const Noise noise = pooled(ends);
  if (noise.freedom < least_freedom_of_noise || !(noise.variance > 0.0)) return;
  Occurrences often{0, {}, {}};
  double worst = 0.0;
  for (std::size_t k = 0; k < rests.size(); ++k) {
    const double change = left_in(work, rests[k].first) - ends[k].mean;
    const double variance = noise.variance * (1.0 / work.rows.weights[rests[k].first] + 1.0 / ends[k].weight);
    const double chance = chance_of_ratio(square(change) / variance, 1.0, noise.freedom);
    if (chance * static_cast<double>(rests.size()) > begins_by_chance || std::abs(change) < rounding_share * largest)
      continue;
    const Place place{work.solution.segments[rests[k].segment].label};
    if (++often.count == 1) often.first = place;
    if (const double times = std::abs(change) / std::sqrt(variance); times > worst) worst = times, often.worst = place;
  }
  if (often.count == 0 || misplaced(work.solution.findings)) return;
  work.solution.findings.push_back(
      {Finding::Severity::warning, "segments_begin_unsettled", {{"times", worst}}, problem.role, often});
}

}  // namespace tumble::linear
