#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"

namespace tumble::entries {
namespace {

struct Extremes {
  double lowest = std::numeric_limits<double>::infinity(), highest = -std::numeric_limits<double>::infinity();
};

Extremes extremes_of(const Recordings& recordings, const std::string& name) {
  Extremes extremes;
  for (const Recording& recording : recordings)
    if (const Channel* channel = find_channel(recording, name))
      for (const double value : channel->values)
        if (!std::isnan(value)) {
          extremes.lowest = std::min(extremes.lowest, value);
          extremes.highest = std::max(extremes.highest, value);
        }
  return extremes;
}

/// The range ends at 85 % of what the channel reaches, on both sides of its middle.
void clip_channel(const Plan&, Recordings& recordings, const Happening& what) {
  constexpr double part = 0.85;
  const auto [lowest, highest] = extremes_of(recordings, what.target);
  const double middle = 0.5 * (lowest + highest), half = 0.5 * part * (highest - lowest);
  edit_values(recordings, what.target, [&](double value) { return std::clamp(value, middle - half, middle + half); });
}

/// Counts, of which the largest is beyond the greatest power of two in them: a register of that many bits begins anew.
void overflow(const Plan&, Recordings& recordings, const Happening& what) {
  const auto [lowest, highest] = extremes_of(recordings, what.target);
  const double largest = std::max(std::abs(lowest), std::abs(highest));
  if (!(largest > 1.0)) return;
  const double half = std::exp2(std::floor(std::log2(largest)));
  edit_values(recordings, what.target,
              [&](double value) { return value - 2.0 * half * std::floor((value + half) / (2.0 * half)); });
}

std::vector<std::string> large_counts(const Plan& plan, const Recordings& recordings) {
  constexpr double least = 64.0;  // a register of eight bits and fewer is no counter of a test
  std::vector<std::string> names;
  for (const std::string& name : outputs(plan, recordings)) {
    const auto count = [&](const Recording& recording) {
      const Channel* channel = find_channel(recording, name);
      return channel != nullptr && channel->kind == QuantityKind::count;
    };
    const auto [lowest, highest] = extremes_of(recordings, name);
    if (std::ranges::any_of(recordings, count) && std::max(std::abs(lowest), std::abs(highest)) > least)
      names.push_back(name);
  }
  return names;
}

/// A step of one standard deviation of the noise costs a mean nothing.
double covered_step(const Plan&, const Recordings& recordings, const std::string& target) {
  return noise_of(recordings, target);
}

void round_values(const Plan&, Recordings& recordings, const Happening& what) {
  edit_values(recordings, what.target, [&](double value) { return std::round(value / what.size) * what.size; });
}

}  // namespace

std::vector<Departure> of_converters() {
  return {
      {.name = "output_clips",
       .summary = "the range of the acquisition ends below the greatest values of an output",
       .targets = outputs,
       .told_by = {"saturated_highest", "saturated_lowest", "segment_clipped", "channel_clipped", "move_clipped",
                   "tone_clipped", "tone_clipped_in_noise", "unit_clips", "tone_beyond_range"},
       .record = clip_channel},
      {.name = "reference_clips",
       .summary = "the range of a reference sensor ends below its greatest values",
       .targets = reference_sensors,
       .told_by = {"saturated_highest", "saturated_lowest", "reference_not_usable", "channel_clipped", "tone_clipped"},
       .record = clip_channel},
      {.name = "counter_overflows",
       .summary = "the register of a counter is too small and begins anew",
       .targets = large_counts,
       .told_by = {"counter_overflow", "counter_overflow_corrected"},
       .record = overflow},
      {.name = "resolution_coarse",
       .summary = "the converter of an output has coarse steps",
       .targets = outputs,
       .told_by = {"output_coarser_than_noise", "one_value_in_segment", "stuck_output", "rounding_moves_means"},
       .covered = covered_step,
       .record = round_values}};
}

}  // namespace tumble::entries
