#include <algorithm>
#include <cmath>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"

namespace tumble::entries {
namespace {

/// A tenth of a sample: coarser stamps show by their scatter.
double tenth_of_a_sample(const Plan&, const Recordings& recordings, const std::string& target) {
  return 0.1 * sample_interval(recordings, target);
}

void shift(Recordings& recordings, const std::string& name, double seconds) {
  edit_channel(recordings, name, [&](Channel& channel) {
    if (channel.timeline.uniform())
      channel.timeline.start += seconds;
    else
      restamp(channel, [&](double time, std::size_t) { return time + seconds; });
  });
}

void stamp_late(const Plan& plan, Recordings& recordings, const Happening& what) {
  for (const std::string& name : all_outputs(plan, recordings)) shift(recordings, name, what.size);
}

void stamp_references_late(const Plan& plan, Recordings& recordings, const Happening& what) {
  for (const std::string& name : references(plan, recordings)) shift(recordings, name, what.size);
}

void stamp_ends(const Plan& plan, Recordings& recordings, const Happening& what) {
  const double interval = sample_interval(recordings, what.target);
  for (const std::string& name : all_outputs(plan, recordings)) shift(recordings, name, interval);
}

/// Eight samples arrive together, as a USB serial adapter hands them over, and get the stamp of their arrival, each a
/// hundredth of a sample after the one before.
void stamp_bursts(const Plan& plan, Recordings& recordings, const Happening& what) {
  constexpr std::size_t together = 8;
  const double interval = sample_interval(recordings, what.target);
  edit_channels(recordings, all_outputs(plan, recordings), [&](Channel& channel) {
    const std::vector<double> taken = [&] {
      std::vector<double> times(channel.values.size());
      for (std::size_t i = 0; i < times.size(); ++i) times[i] = channel.time(i);
      return times;
    }();
    restamp(channel, [&](double, std::size_t i) {
      const std::size_t last = std::min(taken.size() - 1, i / together * together + together - 1);
      return taken[last] + 0.01 * interval * static_cast<double>(i % together);
    });
  });
}

/// Steps of a whole decimal of a second, so that a later stamp is never before an earlier one.
void round_stamps(const Plan&, Recordings& recordings, const Happening& what) {
  for (Recording& recording : recordings)
    for (Channel& channel : recording.channels)
      restamp(channel, [&](double time, std::size_t) { return std::round(time / what.size) * what.size; });
}

std::vector<std::string> outputs_beside_references(const Plan& plan, const Recordings& recordings) {
  return references(plan, recordings).empty() ? std::vector<std::string>{} : whole_test(plan, recordings);
}

}  // namespace

std::vector<Departure> of_stamps() {
  return {{.name = "stamps_late",
           .summary = "all outputs are stamped later than they were measured; marks and references are not",
           .targets = whole_test,
           .told_by = {"segments_begin_in_last", "segments_end_in_next", "clocks_disagree", "output_lags",
                       "K_I_is_a_lag", "gyros_late_on_angles", "output_late_on_temperature", "samples_late_on_marks"},
           .unit = "s",
           .covered = half_a_sample,
           .record = stamp_late},
          {.name = "reference_late",
           .summary = "encoders, thermometers and reference sensors are stamped later than they were measured",
           .targets = outputs_beside_references,
           .told_by = {"unit_follows_thermometer_late", "drift_lags_temperature", "output_lags", "K_I_is_a_lag",
                       "turn_late", "move_not_over", "gyros_late_on_angles", "output_late_on_temperature",
                       "power_ups_begin_in_last"},
           .unit = "s",
           .covered = half_a_sample,
           .record = stamp_references_late},
          {.name = "stamps_at_end",
           .summary = "outputs are stamped at the end of their sample and not at its beginning",
           .targets = whole_test,
           .told_by = {"output_lags", "K_I_is_a_lag", "gyros_late_on_angles"},
           .record = stamp_ends},
          {.name = "stamps_in_bursts",
           .summary = "eight samples arrive together and are stamped at their arrival",
           .targets = whole_test,
           .told_by = {"jitter", "jitter_with_pauses", "rate_not_constant", "irregular_samples", "stamps_scatter",
                       "stamps_scatter_without_rest"},
           .record = stamp_bursts},
          {.name = "stamps_rounded",
           .summary = "stamps are rounded to a tick",
           .targets = whole_test,
           .told_by = {"coarse_stamps", "duplicate_stamps", "jitter", "rate_not_constant", "stamps_scatter"},
           .unit = "s",
           .covered = tenth_of_a_sample,
           .record = round_stamps}};
}

}  // namespace tumble::entries
