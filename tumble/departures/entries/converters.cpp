#include <algorithm>
#include <cmath>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"
#include "tumble/math/extremes.hpp"

namespace tumble::entries {
namespace {

Extremes extremes_in(const Recordings& recordings, const std::string& name) {
  Extremes extremes;
  for (const Recording& recording : recordings)
    if (const Channel* channel = find_channel(recording, name)) extremes.add(extremes_of(channel->values));
  return extremes;
}

/// The greatest size of a sample [SI]; 0 without samples.
double largest_in(const Recordings& recordings, const std::string& name) {
  const Extremes extremes = extremes_in(recordings, name);
  return extremes.present == 0 ? 0.0 : std::max(std::abs(extremes.lowest), std::abs(extremes.highest));
}

/// The range ends at 85 % of what the channel reaches, on both sides of its middle.
void clip_channel(const Plan&, Recordings& recordings, const Happening& what) {
  constexpr double part = 0.85;
  const Extremes all = extremes_in(recordings, what.target);
  const double middle = 0.5 * (all.lowest + all.highest), half = 0.5 * part * (all.highest - all.lowest);
  edit_values(recordings, what.target, [&](double value) { return std::clamp(value, middle - half, middle + half); });
}

/// Counts, of which the largest is beyond the greatest power of two in them: a register of that many bits begins anew.
void overflow(const Plan&, Recordings& recordings, const Happening& what) {
  const double largest = largest_in(recordings, what.target);
  if (!(largest > 1.0)) return;
  const double half = std::exp2(std::floor(std::log2(largest)));
  edit_values(recordings, what.target,
              [&](double value) { return value - 2.0 * half * std::floor((value + half) / (2.0 * half)); });
}

std::vector<std::string> large_counts(const Plan& plan, const Recordings& recordings) {
  constexpr double least = 64.0;  // a register of eight bits and fewer is no counter of a test
  std::vector<std::string> names = outputs(plan, recordings);
  std::erase_if(names, [&](const std::string& name) {
    return !is_count(recordings, name) || !(largest_in(recordings, name) > least);
  });
  return names;
}

/// A step of one standard deviation of the noise costs a mean nothing.
double covered_step(const Plan&, const Recordings& recordings, const std::string& target) {
  return noise_of(recordings, target);
}

/// A converter rounds each sample. A counter has whole pulses; one with coarse steps has a divider before it, which counts
/// every n-th pulse and passes the rest on to the next window.
void round_values(const Plan&, Recordings& recordings, const Happening& what) {
  if (is_count(recordings, what.target))
    return divide_counts(recordings, what.target, std::max(1.0, std::round(what.size)));
  edit_values(recordings, what.target, [&](double value) { return std::round(value / what.size) * what.size; });
}

}  // namespace

std::vector<Departure> of_converters() {
  return {{.name = "output_clips",
           .summary = "the range of the acquisition ends below the greatest values of an output",
           .targets = outputs,
           .told_by = {"saturated_highest", "saturated_lowest", "segment_clipped", "channel_clipped", "move_clipped",
                       "tone_clipped", "tone_clipped_in_noise", "unit_clips", "tone_beyond_range"},
           .record = clip_channel},
          {.name = "reference_clips",
           .summary = "the range of a reference sensor ends below its greatest values",
           .targets = reference_sensors,
           .told_by = {"saturated_highest", "saturated_lowest", "reference_not_usable", "channel_clipped",
                       "tone_clipped", "reference_clipped"},
           .record = clip_channel},
          {.name = "counter_overflows",
           .summary = "the register of a counter is too small and begins anew",
           .targets = large_counts,
           .told_by = {"counter_overflow", "counter_overflow_corrected"},
           .record = overflow},
          {.name = "resolution_coarse",
           .summary = "the converter of an output has coarse steps",
           .targets = outputs,
           .told_by = {"output_coarser_than_noise", "one_value_in_segment", "stuck_output", "rounding_moves_means",
                       "steps_exceed_noise", "counts_in_steps"},
           .covered = covered_step,
           .record = round_values}};
}

}  // namespace tumble::entries
