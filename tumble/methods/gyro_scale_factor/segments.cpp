#include "tumble/methods/gyro_scale_factor/segments.hpp"

#include <algorithm>
#include <cmath>

namespace tumble::gyro_scale_factor {
namespace {

using linear::SegmentSummary;

constexpr double one_rate = 1e-4, one_rate_floor = 1e-12;  ///< [1] of the range and [rad/s], within which rates are one

}  // namespace

std::pair<double, double> straight(const Segments& segments) {
  double w = 0.0, y = 0.0, ww = 0.0, wy = 0.0;
  const auto n = static_cast<double>(segments.size());
  for (const auto* s : segments) w += s->felt.rate.x / n, y += s->measured / n;
  for (const auto* s : segments) {
    const double d = s->felt.rate.x - w;
    ww += d * d;
    wy += d * (s->measured - y);
  }
  const double slope = ww > 0.0 ? wy / ww : 0.0;
  return {y - slope * w, slope};
}

Segments all_of(const linear::Solution& solution) {
  Segments all;
  for (const auto& segment : solution.segments)
    if (!std::isnan(segment.measured)) all.push_back(&segment);
  return all;
}

std::vector<Segments> groups_of(Segments segments, double range) {
  std::ranges::stable_sort(segments, {}, [](const SegmentSummary* s) { return s->felt.rate.x; });
  std::vector<Segments> groups;
  for (const auto* s : segments) {
    if (groups.empty() || s->felt.rate.x - groups.back().back()->felt.rate.x > one_rate * range + one_rate_floor)
      groups.emplace_back();
    groups.back().push_back(s);
  }
  return groups;
}

double mean_of(const Segments& group) {
  double sum = 0.0;
  for (const auto* s : group) sum += s->measured;
  return sum / static_cast<double>(group.size());
}

}  // namespace tumble::gyro_scale_factor
