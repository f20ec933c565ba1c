#include <algorithm>
#include <cmath>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"

namespace tumble::entries {
namespace {

/// Low pass of first order whose lag at low frequencies is `lag` [s] for steps of any length.
Response low_pass(double lag, double step) {
  return [part = step / (step + lag), value = std::nan("")](std::span<double> samples) mutable {
    for (double& sample : samples) sample = value = std::isnan(value) ? sample : value + part * (sample - value);
  };
}

/// Two low passes of half the lag: a loop of second order that does not overshoot.
void add_loop(const Plan&, Recordings& recordings, const Happening& what) {
  for (int stage = 0; stage < 2; ++stage)
    pass_through(recordings, what.target, [&](double step) { return low_pass(0.5 * what.size, step); });
}

void add_filter(const Plan&, Recordings& recordings, const Happening& what) {
  pass_through(recordings, what.target, [&](double step) { return low_pass(what.size, step); });
}

std::vector<std::string> outputs_that_are_no_counts(const Plan& plan, const Recordings& recordings) {
  std::vector<std::string> names = outputs(plan, recordings);
  std::erase_if(names, [&](const std::string& name) { return is_count(recordings, name); });
  return names;
}

/// Noise of a sample: what a converter's fault changes less than this disappears in it.
double covered_noise(const Plan&, const Recordings& recordings, const std::string& target) {
  return noise_of(recordings, target);
}

void ignore_small(const Plan&, Recordings& recordings, const Happening& what) {
  edit_values(recordings, what.target, [&](double value) { return std::abs(value) <= what.size ? 0.0 : value; });
}

double covered_asymmetry(const Plan&, const Recordings&, const std::string&) { return 100e-6; }  // as a gain

void amplify_positive(const Plan&, Recordings& recordings, const Happening& what) {
  edit_measured(recordings, what.target, [&](double value) { return value > 0.0 ? value * (1.0 + what.size) : value; });
}

}  // namespace

std::vector<Departure> of_electronics() {
  return {
      {.name = "loop_unstated",
       .summary = "a rebalance loop that nobody stated is between an output and its record; its size is its lag",
       .targets = outputs_that_are_no_counts,
       .told_by = {"loop_lag_estimated", "loop_lag_unknown", "loop_lag_differs", "output_lags", "K_I_is_a_lag",
                   "process_like_filter", "filter_near_slow_terms", "segment_still_changes", "segments_begin_unsettled",
                   "reference_late_on_angles", "reference_late_or_sensitive", "output_late_on_temperature"},
       .unit = "s",
       .covered = half_a_sample,
       .record = add_loop},
      {.name = "filter_unstated",
       .summary = "a low pass of first order that nobody stated is behind an output; its size is its time constant",
       .targets = outputs_that_are_no_counts,
       .told_by = {"process_like_filter", "filter_near_slow_terms", "noise_below_terms", "deviation_below_terms",
                   "loop_lag_estimated", "loop_lag_unknown", "output_lags", "K_I_is_a_lag", "segment_still_changes",
                   "segments_begin_unsettled", "loop_lag_differs", "reference_late_on_angles",
                   "reference_late_or_sensitive", "output_late_on_temperature"},
       .unit = "s",
       .covered = half_a_sample,
       .record = add_filter},
      {.name = "dead_band",
       .summary = "an output shows zero for small inputs",
       .targets = outputs,
       .told_by = {"stuck_output", "below_smallest_input", "beyond_linear_form", "one_value_in_segment",
                   "level_positions_count_nothing", "no_value_near_zero", "nothing_near_level", "small_counts_lost"},
       .unit = "",
       .covered = covered_noise,
       .record = ignore_small},
      {.name = "asymmetry",
       .summary = "an output has a larger scale factor for positive inputs",
       .targets = outputs,
       .told_by = {"beyond_linear_form", "forward_and_reverse_differ", "output_asymmetric", "output_not_linear",
                   "segments_differ_from_model", "scale_factors_of_senses_differ"},
       .unit = "ppm",
       .covered = covered_asymmetry,
       .record = amplify_positive}};
}

}  // namespace tumble::entries
