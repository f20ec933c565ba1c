#include <cmath>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::entries {
namespace {

double covered_clock(const Plan&, const Recordings&, const std::string&) { return crystal; }

/// The whole recording on a clock that shows `begin + (1 + fast) t`.
void change_clock(Recordings& recordings, double begin, double fast) {
  const auto shown = [&](double time) { return begin + (1.0 + fast) * time; };
  for (Recording& recording : recordings) {
    for (Channel& channel : recording.channels) {
      if (channel.timeline.uniform()) {
        channel.timeline.start = shown(channel.timeline.start);
        channel.timeline.rate /= 1.0 + fast;
      } else {
        restamp(channel, [&](double time, std::size_t) { return shown(time); });
      }
    }
    for (Mark& mark : recording.marks) {
      mark.begin = shown(mark.begin);
      if (std::isfinite(mark.end)) mark.end = shown(mark.end);
    }
  }
}

void stamp_fast(const Plan&, Recordings& recordings, const Happening& what) {
  change_clock(recordings, 0.0, what.size);
}

void begin_in_unix_time(const Plan&, Recordings& recordings, const Happening& what) {
  constexpr double year_2001 = 1e9;  // [s] of Unix time
  change_clock(recordings, std::floor(year_2001 * (1.0 + 0.7 * what.random.uniform(0))), 0.0);
}

/// Windows that are longer hold more pulses; the total stays whole.
void count_longer(const Plan&, Recordings& recordings, const Happening& what) {
  edit_measured(recordings, what.target, [&](double value) { return value * (1.0 + what.size); });
}

std::vector<std::string> counts(const Plan& plan, const Recordings& recordings) {
  std::vector<std::string> names = outputs(plan, recordings);
  std::erase_if(names, [&](const std::string& name) { return !is_count(recordings, name); });
  return names;
}

}  // namespace

std::vector<Departure> of_clocks() {
  return {
      {.name = "clock_fast",
       .summary = "the clock behind the stamps runs fast: all stamps are longer apart than the samples were taken",
       .targets = whole_test,
       .told_by = {"clock_moves_scale_factors", "rate_differs_from_stated", "rate_of_counts_differs",
                   "turn_rate_recorded", "clocks_disagree", "frequency_differs_from_plan", "frequencies_differ_alike"},
       .unit = "ppm",
       .covered = covered_clock,
       .record = stamp_fast},
      {.name = "clock_origin",
       .summary = "the clock begins anywhere: stamps are in Unix time and not from zero",
       .targets = whole_test,
       .told_by = {},
       .record = begin_in_unix_time},
      {.name = "counting_clock",
       .summary = "the clock of the counting windows runs slowly: each window is longer than it says",
       .targets = counts,
       .told_by = {"rate_of_counts_differs", "scale_factor_far_from_given"},
       .unit = "ppm",
       .covered = covered_clock,
       .record = count_longer}};
}

}  // namespace tumble::entries
