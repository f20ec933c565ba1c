#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/core/evidence.hpp"
#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::entries {
namespace {

/// The output approaches its value with a time constant of a tenth of the record, in each file.
void warm_up(const Plan&, Recordings& recordings, const Happening& what) {
  constexpr double part = 0.1;
  add_along(recordings, what.target, [&](double along) { return what.size * std::exp(-along / part); });
}

/// A jump at a time that is drawn from the middle of the record.
void step(const Plan&, Recordings& recordings, const Happening& what) {
  const double at = 0.3 + 0.4 * what.random.uniform(0);
  add_along(recordings, what.target, [&](double along) { return along < at ? 0.0 : what.size; });
}

/// Several cycles of a room whose heating switches: five and a little, at a phase that is drawn.
double room(double along, double phase) {
  constexpr double cycles = 5.3;
  return std::sin(two_pi * (cycles * along + phase));
}

void follow_room(const Plan&, Recordings& recordings, const Happening& what) {
  const double phase = what.random.uniform(0);
  add_along(recordings, what.target, [&](double along) { return what.size * room(along, phase); });
}

/// The thermometer beside it shows 2 K of the cycles.
void follow_recorded_room(const Plan& plan, Recordings& recordings, const Happening& what) {
  follow_room(plan, recordings, what);
  const double phase = what.random.uniform(0);
  for (Recording& recording : recordings) {
    const Channel* output = find_channel(recording, what.target);
    if (output == nullptr) continue;
    Channel thermometer{"temperature", QuantityKind::temperature, Unit::parse("degC"), output->timeline, {}};
    const auto last = static_cast<double>(std::max<std::size_t>(output->values.size(), 2) - 1);
    for (std::size_t i = 0; i < output->values.size(); ++i)
      thermometer.values.push_back(293.15 + 2.0 * room(static_cast<double>(i) / last, phase));
    recording.channels.push_back(std::move(thermometer));
  }
}

std::vector<std::string> without_thermometer(const Plan& plan, const Recordings& recordings) {
  return thermometers(plan, recordings).empty() ? outputs(plan, recordings) : std::vector<std::string>{};
}

std::vector<std::string> of_three_runs(const Plan& plan, const Recordings& recordings) {
  return runs_of(recordings).size() < 3 ? std::vector<std::string>{} : outputs(plan, recordings);
}

/// Adds to the channel in each power-up what the function gives for its number, from 0.
void add_by_run(Recordings& recordings, const std::string& name, const std::function<double(std::size_t run)>& added) {
  const std::vector<Run> runs = runs_of(recordings);
  for (std::size_t k = 0; k < runs.size(); ++k)
    for (Channel& channel : recordings[runs[k].recording].channels) {
      if (channel.name != name) continue;
      Counted counted(channel);
      for (std::size_t i = 0; i < channel.values.size(); ++i)
        if (const double time = channel.time(i); runs[k].begin <= time && time < runs[k].end)
          channel.values[i] = counted(channel.values[i] + added(k));
    }
}

void drift_from_run_to_run(const Plan&, Recordings& recordings, const Happening& what) {
  const auto last = static_cast<double>(runs_of(recordings).size() - 1);
  add_by_run(recordings, what.target, [&](std::size_t run) { return what.size * static_cast<double>(run) / last; });
}

void offset_one_run(const Plan&, Recordings& recordings, const Happening& what) {
  const std::size_t runs = runs_of(recordings).size();
  const auto one = std::min(runs - 1, static_cast<std::size_t>(what.random.uniform(0) * static_cast<double>(runs)));
  add_by_run(recordings, what.target, [&](std::size_t run) { return run == one ? what.size : 0.0; });
}

}  // namespace

// NOLINTNEXTLINE(readability-function-size): a table, one entry after another
std::vector<Departure> of_drifts() {
  return {{.name = "warm_up",
           .summary = "an output approaches its value while the instrument becomes warm",
           .targets = outputs,
           .told_by = {"output_drifts_with_time",
                       "output_drifts_within_segments",
                       "bias_settles",
                       "bias_drifts",
                       "rest_changes",
                       "rest_drifts",
                       "segment_still_changes",
                       "positions_still_change",
                       "drift_moves_azimuth",
                       "more_drift_than_stated",
                       "moves_at_rest",
                       "output_drifts_along_test",
                       "segments_begin_unsettled",
                       "warm_up_subtracted",
                       "bias_drifts_in_sweep",
                       "power_up_settles",
                       "power_ups_share_course",
                       "output_settles_along_record",
                       "bias_settles_in_poses",
                       "bias_drifts_over_rests"},
           .covered = covered_bias,
           .record = warm_up},
          {.name = "temperature_unrecorded",
           .summary = "an output follows the temperature of the room, which nobody records",
           .targets = outputs,
           .told_by = {"more_drift_than_stated", "lines_subtracted", "segments_differ_from_model",
                       "noise_changes_along_record", "unsteady_stay", "beat_in_dead_band", "power_ups_share_course",
                       "output_goes_up_and_down", "output_waves", "rest_wanders"},
           .covered = covered_bias,
           .record = follow_room},
          {.name = "temperature_recorded",
           .summary = "an output follows the temperature of the room, which is recorded beside it",
           .targets = without_thermometer,
           .told_by = {"output_follows_temperature", "more_drift_than_stated", "beat_in_dead_band",
                       "power_ups_share_course", "rest_wanders"},
           .covered = covered_bias,
           .record = follow_recorded_room},
          {.name = "bias_step",
           .summary = "the bias of an output jumps once",
           .targets = outputs,
           .told_by = {"bias_steps_between_rests", "bias_jumps", "jumps", "step_in_segment", "output_drifts_with_time",
                       "repeats_differ_more_than_positions", "more_drift_than_stated", "rest_changes",
                       "position_disagrees", "bias_beyond_stated", "bias_in_turn_differs", "output_steps",
                       "bias_steps_in_sweep", "power_up_steps", "power_ups_share_course"},
           .covered = covered_bias,
           .record = step},
          {.name = "run_drift",
           .summary = "the bias changes evenly from one power-up to the next",
           .targets = of_three_runs,
           .told_by = {"bias_drifts", "output_drifts_with_time", "term_differs", "output_drifts_along_test",
                       "power_ups_drift"},
           .covered = covered_bias,
           .record = drift_from_run_to_run},
          {.name = "run_outlying",
           .summary = "one power-up has another bias than the others",
           .targets = of_three_runs,
           .told_by = {"bias_jumps", "set_disagrees", "turn_differs_from_others", "term_differs", "power_up_differs"},
           .covered = covered_bias,
           .record = offset_one_run}};
}

}  // namespace tumble::entries
