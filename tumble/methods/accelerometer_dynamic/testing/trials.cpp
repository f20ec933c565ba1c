#include "tumble/methods/testing/trials.hpp"

#include "tumble/reduce/linear/testing/table_trial.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::accelerometer_dynamic {
namespace {

constexpr TruthValue coefficients[] = {{"C_I", -12, "ug/(rad/s^2)"},   {"C_O", 900, "ug/(rad/s^2)"},
                                       {"C_P", 8, "ug/(rad/s^2)"},     {"C_IP", 850, "ug/(rad/s)^2"},
                                       {"C_OP", -12, "ug/(rad/s)^2"},  {"C_IO", 8, "ug/(rad/s)^2"},
                                       {"C_II", 15, "ug/(rad/s)^2"},   {"C_PP", -15, "ug/(rad/s)^2"},
                                       {"C_III", -4, "ppm/(rad/s)^2"}, {"C_IPP", 4, "ppm/(rad/s)^2"}};

/// Positions, rates about one and two axes, and oscillations on a two-axis table.
Trial trial(std::uint64_t seed) {
  Plan plan = trial_plan("accelerometer_dynamic", find_method("accelerometer_dynamic").options(),
                         "pendulous_accelerometer", "two_axis_table", 20.0);
  const auto set = [&](const char* name, double value, const char* unit) { set_truth(plan, name, value, unit); };
  set_truth(plan, coefficients);
  set("bias", 2.5, "mg");
  set("scale_factor_error", 120, "ppm");
  set("misalignment_o", 40, "arcsec");
  set("misalignment_p", -25, "arcsec");
  set("angle_random_walk", 0.003, "(m/s)/sqrt(h)");
  set("bias_instability", 3, "ug");
  linear::add_table_motions(plan);
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  for (const auto& coefficient : coefficients)
    trial.truth.emplace_back(coefficient.name, plan.truth.number(coefficient.name));
  return trial;
}

/// Coefficients of the other sign, other speeds and oscillations on a table whose axis is tilted, at another site; a
/// current of negative scale factor through the sensor's averaging, with samples missing.
Trial second_trial(std::uint64_t seed) {
  Plan plan = trial_plan("accelerometer_dynamic", find_method("accelerometer_dynamic").options(),
                         "pendulous_accelerometer", "two_axis_table", 25.0);
  plan.site = Site{si(-33.9, "deg"), si(18.4, "deg"), 1700.0, {}};
  plan.rig.set_number("outer_azimuth", si(37.0, "deg"), Unit::parse("deg"));
  plan.rig.set_number("outer_elevation", si(20.0, "deg"), Unit::parse("deg"));
  for (const auto& [name, value, unit] : coefficients) set_truth(plan, name, -1.5 * value, unit);
  set_truth(plan, "bias", -1.5, "mg");
  set_truth(plan, "scale_factor_error", -200, "ppm");
  set_truth(plan, "misalignment_o", -60, "arcsec");
  set_truth(plan, "misalignment_p", 35, "arcsec");
  set_truth(plan, "angle_random_walk", 0.005, "(m/s)/sqrt(h)");
  set_truth(plan, "bias_instability", 2, "ug");
  set_truth(plan, "current_scale_factor", -1.25, "mA/g");
  plan.truth.set_word("output", "current");
  plan.truth.set_integer("oversampling", 6);
  plan.settings.set_word("scale_factor", "-1.25 mA/g");
  linear::add_table_motions(plan, 40.0, 12.0, 0.7);
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  lose_samples(trial.evidence.recordings.front(), seed, 50);
  for (const auto& coefficient : coefficients)
    trial.truth.emplace_back(coefficient.name, plan.truth.number(coefficient.name));
  return trial;
}

}  // namespace

extern const Trials trials{trial, second_trial};

}  // namespace tumble::accelerometer_dynamic
