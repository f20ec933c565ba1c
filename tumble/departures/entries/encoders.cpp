#include <algorithm>
#include <cmath>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"
#include "tumble/math/extremes.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::entries {
namespace {

/// The scale of an axis that makes no whole turn (an inductive scale, a potentiometer) is adjusted to this. Over a whole turn a
/// disc cannot be off: it has a whole number of lines. There the reader is told a wrong number, of which the smallest error,
/// one line of 36 000, is the smallest of the three sizes.
double covered_gain(const Plan&, const Recordings& recordings, const std::string& target) {
  constexpr double adjusted = 10e-6, lines = 36000.0, smallest_size = 0.3;
  for (const Recording& recording : recordings) {
    const Channel* channel = find_channel(recording, target);
    if (channel == nullptr) continue;
    const Extremes extremes = extremes_of(channel->values);
    if (extremes.present > 0 && extremes.highest - extremes.lowest > two_pi) return 1.0 / lines / smallest_size;
  }
  return adjusted;
}

void hold_first(const Plan&, Recordings& recordings, const Happening& what) {
  edit_channel(recordings, what.target, [](Channel& channel) {
    if (!channel.values.empty()) std::ranges::fill(channel.values, channel.values.front());
  });
}

}  // namespace

// NOLINTNEXTLINE(readability-function-size): a table, one entry after another
std::vector<Departure> of_encoders() {
  return {{.name = "encoder_gain",
           .summary = "an encoder shows larger angles and rates than the axis has",
           .targets = encoders,
           .told_by = {"angle_off_plan", "turn_rate_recorded", "rates_differ_from_plan", "line_turns_against_angle",
                       "angles_off_in_proportion"},
           .unit = "ppm",
           .covered = covered_gain,
           .record =
               [](const Plan&, Recordings& recordings, const Happening& what) {
                 edit_values(recordings, what.target, [&](double angle) { return angle * (1.0 + what.size); });
               }},
          {.name = "encoder_sign",
           .summary = "an encoder counts in the other direction than the axis turns",
           .targets = encoders,
           .told_by = {"angle_off_plan", "turn_rate_recorded", "arm_turns_the_other_way", "table_turns_the_other_way",
                       "axis_moves_the_other_way", "gyro_reversed"},
           .record =
               [](const Plan&, Recordings& recordings, const Happening& what) {
                 edit_values(recordings, what.target, [](double angle) { return -angle; });
               }},
          {.name = "encoder_index",
           .summary = "the zero of an encoder is at another angle than planned",
           .targets = encoders,
           .told_by = {"angle_off_plan", "encoder_zero_off_plan", "turn_phase_recorded"},
           .unit = "arcsec",
           .covered = covered_index,
           .record =
               [](const Plan&, Recordings& recordings, const Happening& what) {
                 edit_values(recordings, what.target, [&](double angle) { return angle + what.size; });
               }},
          {.name = "encoder_at_rest",
           .summary = "an encoder shows the same angle throughout, while the axis moves",
           .targets = encoders,
           .told_by = {"angles_not_recorded", "angle_off_plan", "another_motion_recorded", "turn_rate_recorded",
                       "constant_output", "channel_constant", "stuck_output"},
           .record = hold_first},
          {.name = "encoder_wraps",
           .summary = "an encoder begins again at zero after each turn of 360 deg",
           .targets = encoders,
           .told_by = {},
           .record = [](const Plan&, Recordings& recordings, const Happening& what) {
             edit_values(recordings, what.target,
                         [](double angle) { return angle - two_pi * std::floor(angle / two_pi); });
           }}};
}

}  // namespace tumble::entries
