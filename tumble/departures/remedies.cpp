#include "tumble/departures/remedies.hpp"

#include <algorithm>
#include <vector>

#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// What shows these departures.
struct Remedy {
  const char* words;
  std::vector<std::string_view> departures;
};

const std::vector<Remedy>& remedies() {
  static const std::vector<Remedy> all{
      {"a second clock: the time of a server or a pulse of the rig, recorded with the output",
       {"clock_fast", "clock_origin", "counting_clock", "stamps_late", "reference_late", "stamps_at_end",
        "stamps_in_bursts", "stamps_rounded"}},
      {"an encoder on the axis, recorded with the output",
       {"order_changed", "labels_exchanged", "position_missing", "position_twice", "motion_amplitude", "motion_rate",
        "motion_frequency", "motion_sign", "positions_offset", "positions_drift", "rig_slow", "marks_late"}},
      {"a level on the base, read before and after the test", {"level_off", "level_drifts"}},
      {"the azimuth of the base by a second reference: a theodolite, a north finder", {"azimuth_off"}},
      {"a second accelerometer on the fixture, across the main motion", {"cross_motion"}},
      {"gravity and latitude of the site from a second source", {"gravity_wrong", "latitude_wrong"}},
      {"a position that the rig defines without its encoder: a stop, a level face, a whole turn",
       {"encoder_gain", "encoder_sign", "encoder_index", "encoder_at_rest", "encoder_wraps"}},
      {"a known input of known sign before the test: a face up, a turn by hand",
       {"channel_sign", "outputs_exchanged", "references_exchanged", "unit_wrong", "kelvin"}},
      {"a second reference through the same acquisition, calibrated elsewhere", {"output_gain", "reference_gain"}},
      {"the same input at a second rate or frequency, and pauses after moves", {"loop_unstated", "filter_unstated"}},
      {"inputs of both signs and of several sizes, small and great ones among them",
       {"dead_band", "asymmetry", "output_clips", "reference_clips", "counter_overflows", "resolution_coarse"}},
      {"a number in each sample that counts on, recorded with the output",
       {"samples_repeated", "samples_zero", "rows_lost", "values_lost", "recording_split", "recordings_joined"}},
      {"a closing position: the first one again at the end, and a longer warm-up", {"warm_up", "bias_step"}},
      {"a thermometer at the instrument, recorded with the output",
       {"temperature_unrecorded", "temperature_recorded", "motor_heat"}},
      {"more power-ups on further days", {"run_drift", "run_outlying"}},
      {"the same positions with the instrument turned in its mount", {"magnetic"}}};
  return all;
}

}  // namespace

std::string_view remedy_of(std::string_view departure) {
  for (const Remedy& remedy : remedies())
    if (std::ranges::find(remedy.departures, departure) != remedy.departures.end()) return remedy.words;
  throw Error(Error::Kind::internal, say("no remedy of the departure '{}' is listed", Name{std::string(departure)}));
}

}  // namespace tumble
