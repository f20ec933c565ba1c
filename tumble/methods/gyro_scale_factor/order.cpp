#include <algorithm>
#include <cmath>
#include <optional>

#include "tumble/math/median.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/methods/gyro_scale_factor/departures.hpp"
#include "tumble/methods/gyro_scale_factor/segments.hpp"

namespace tumble::gyro_scale_factor {
namespace {

using linear::SegmentSummary;

/// [1] of the range that two rates are apart, so that one is no small change of the other: thresholds are looked for below it.
constexpr double rates_apart = 0.02;
constexpr double beyond_usual = 10.0;       ///< [sd of a segment about the line] that the segment is off its own rate
constexpr double near_other = 0.1;          ///< [1] of that distance, within which it agrees with the other rate
constexpr std::size_t fewest_segments = 6;  ///< of which one or two do not move the line

/// A line that a few wrong segments do not move: the median of the slopes of all pairs.
struct RobustLine {
  double offset = 0.0, slope = 0.0, scatter = 0.0;
  double at(const SegmentSummary& segment) const { return offset + slope * segment.felt.rate.x; }
};

std::optional<RobustLine> robust_line(const Segments& segments, double range) {
  std::vector<double> slopes, offsets, left;
  for (std::size_t i = 0; i < segments.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (const double apart = segments[i]->felt.rate.x - segments[k]->felt.rate.x;
          std::abs(apart) > rates_apart * range)
        slopes.push_back((segments[i]->measured - segments[k]->measured) / apart);
  if (slopes.empty()) return {};
  RobustLine line{.slope = median(std::move(slopes))};
  for (const auto* s : segments) offsets.push_back(s->measured - line.slope * s->felt.rate.x);
  line.offset = median(std::move(offsets));
  for (const auto* s : segments) left.push_back(std::max(std::abs(s->measured - line.at(*s)), s->sd));
  line.scatter = sd_of_median_size * median(std::move(left));
  return line;
}

/// The segment of another rate that this one agrees with; null: there is none.
const SegmentSummary* other_like(const SegmentSummary& segment, const Segments& segments, const RobustLine& line,
                                 double range) {
  const double off = segment.measured - line.at(segment);
  const SegmentSummary* best = nullptr;
  double least = near_other * std::abs(off);
  for (const auto* other : segments) {
    const double left = std::abs(segment.measured - line.at(*other));
    if (std::abs(other->felt.rate.x - segment.felt.rate.x) < rates_apart * range || left >= least) continue;
    best = other, least = left;
  }
  return best;
}

}  // namespace

Findings about_order(const linear::Solution& solution, const Line& line) {
  const Segments segments = all_of(solution);
  const auto usual = segments.size() < fewest_segments ? std::nullopt : robust_line(segments, line.range);
  if (!usual) return {};
  Findings findings;
  for (const auto* s : segments) {
    if (std::abs(s->measured - usual->at(*s)) < beyond_usual * usual->scatter) continue;
    if (const SegmentSummary* other = other_like(*s, segments, *usual, line.range))
      findings.push_back(
          {Finding::Severity::error, "segment_reads_as_another", {{"segment", s->label}, {"other", other->label}}});
  }
  return findings;
}

}  // namespace tumble::gyro_scale_factor
