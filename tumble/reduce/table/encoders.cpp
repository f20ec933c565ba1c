#include "tumble/reduce/table/encoders.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/extremes.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::table {
namespace {

constexpr double other_reading = 1e-15;  ///< [1] of the largest: a smaller change is rounding
constexpr double greatest_step = 1e-3;   ///< [rad] a greater step is a motion
constexpr double full_turn = 1.001;      ///< [turns] a wrapped angle has no greater range

/// Resolution [rad]: the smallest change between readings; 0 where it is not visible.
double step_of(const Channel& channel) {
  double step = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (std::size_t i = 1; i < channel.values.size(); ++i) {
    const double change = std::abs(channel.values[i] - channel.values[i - 1]);
    if (std::isnan(change)) continue;
    largest = std::max(largest, std::abs(channel.values[i]));
    if (change > other_reading * largest) step = std::min(step, change);
  }
  return std::isfinite(step) && step < greatest_step ? step : 0.0;
}

}  // namespace

std::vector<PlacedSegment> places_of(const std::vector<MarkedSegment>& marks, const std::vector<double>& settled) {
  std::vector<PlacedSegment> places;
  for (const auto& marked : marks)
    if (marked.planned != nullptr && marked.planned->run == marked.run)
      places.push_back({marked.index, marked.begin, marked.begin + settled[marked.index],
                        std::min(marked.end, marked.begin + marked.planned->duration)});
  return places;
}

std::vector<Encoder> encoders_of(const Evidence& evidence, std::size_t recording) {
  std::vector<Encoder> encoders;
  for (const auto& axis : find_rig(plan_of(evidence, recording).rig_kind).axes()) {
    const Channel* channel = channel_for(evidence, evidence.recordings[recording], axis.name + "_angle");
    if (channel == nullptr || channel->values.size() < 2 || channel->kind != QuantityKind::angle) continue;
    const Extremes extremes = extremes_of(channel->values);
    if (extremes.present == 0) continue;
    encoders.push_back(
        {axis.name, channel, extremes.highest - extremes.lowest > full_turn * two_pi, step_of(*channel)});
  }
  return encoders;
}

const Motion* motion_of(const Segment& segment, const std::string& axis) {
  const auto motion = segment.axes.find(axis);
  return motion == segment.axes.end() ? nullptr : &motion->second;
}

bool recorded_alone(const Evidence& evidence, std::size_t recording) {
  const auto& entries = evidence.plan.recordings;
  return recording < entries.size() && !entries[recording].segment.empty();
}

}  // namespace tumble::table
