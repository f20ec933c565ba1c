#include <algorithm>
#include <cmath>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"

namespace tumble::entries {
namespace {

/// The sensor gives 73 values in the time of 100 samples; the others hold the one before.
void hold_slow(const Plan&, Recordings& recordings, const Happening& what) {
  constexpr double share = 0.73;
  edit_channel(recordings, what.target, [](Channel& channel) {
    const std::vector<double> taken = channel.values;
    for (std::size_t i = 0; i < taken.size(); ++i) {
      const double last = std::floor(static_cast<double>(i) * share) / share;  // the sample at or before this one
      channel.values[i] = taken[std::min(i, static_cast<std::size_t>(std::ceil(last)))];
    }
  });
}

/// One sample in 200 is written as zero.
void write_zeros(const Plan&, Recordings& recordings, const Happening& what) {
  constexpr double share = 1.0 / 200.0;
  edit_channel(recordings, what.target, [&](Channel& channel) {
    const RandomStream random = what.random.split(channel.name);
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      if (random.uniform(i) < share) channel.values[i] = 0.0;
  });
}

/// One row in 50 is lost, and a hundredth of the rows in one piece, in all channels of a recording.
void lose_rows(const Plan&, Recordings& recordings, const Happening& what) {
  constexpr double share = 1.0 / 50.0, piece = 0.01;
  const double begin = 0.2 + 0.6 * what.random.uniform(0);
  for (Recording& recording : recordings)
    for (Channel& channel : recording.channels) {
      const auto size = static_cast<double>(channel.values.size());
      remove_samples(channel, [&](std::size_t i) {
        const double fraction = static_cast<double>(i) / size;
        return what.random.uniform(i + 1) < share || (begin <= fraction && fraction < begin + piece);
      });
    }
}

/// The largest tenth of the values is lost: a filter of outliers that does not know the signal.
void lose_large(const Plan&, Recordings& recordings, const Happening& what) {
  edit_channel(recordings, what.target, [](Channel& channel) {
    std::vector<double> sorted;
    std::ranges::copy_if(channel.values, std::back_inserter(sorted), [](double v) { return !std::isnan(v); });
    if (sorted.empty()) return;
    const auto limit = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 9 / 10);
    std::nth_element(sorted.begin(), limit, sorted.end());
    for (double& value : channel.values)
      if (value > *limit) value = std::nan("");
  });
}

}  // namespace

std::vector<Departure> of_samples() {
  return {{.name = "samples_repeated",
           .summary = "a sensor gives 73 values in the time of 100 samples, and the record repeats them",
           .targets = outputs,
           .told_by = {"stuck_output", "noise_below_terms", "samples_repeat"},
           .record = hold_slow},
          {.name = "samples_zero",
           .summary = "one sample in 200 of an output is written as zero",
           .targets = outputs,
           .told_by = {"outlier", "outliers", "single_outliers", "outliers_together", "damaged_sample", "windows_off",
                       "zeros_in_place_of_samples", "zeros_not_used"},
           .record = write_zeros},
          {.name = "rows_lost",
           .summary = "rows of the record are lost, single ones and a whole piece",
           .targets = whole_test,
           .told_by = {"gap"},
           .record = lose_rows},
          {.name = "values_lost",
           .summary = "the largest values of an output are lost",
           .targets = outputs,
           .told_by = {"largest_values_missing",
                       "large_values_lost"},  // missing_samples does not say that they are the largest
           .record = lose_large}};
}

}  // namespace tumble::entries
