#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include "tumble/earth/earth.hpp"
#include "tumble/methods/accelerometer_tumble/report.hpp"
#include "tumble/methods/accelerometer_tumble/testing/trial.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::accelerometer_tumble {
namespace {

constexpr TruthValue coefficients[] = {
    {"second_order_coefficient", 18, "ug/g^2"}, {"third_order_coefficient", -9, "ug/g^3"},
    {"cross_coupling_ip", 25, "ug/g^2"},        {"cross_coupling_io", -14, "ug/g^2"},
    {"misalignment_o", 95, "arcsec"},           {"misalignment_p", -60, "arcsec"},
    {"second_order_pp", -18, "ug/g^2"},         {"second_order_oo", 4, "ug/g^2"}};

void add_position(Plan& plan, double roll, double angle) {
  plan.schedule.push_back({fmt::format("roll {:g} at {:g}", roll, angle),
                           100.0,
                           1,
                           {{"head", {.kind = Motion::Kind::hold, .value = si(angle, "deg")}},
                            {"mount_roll", {.kind = Motion::Kind::hold, .value = si(roll, "deg")}}}});
}

/// What 1 g shows of the trial's coefficients.
void add_truth(const char* scale_factor, Trial& trial) {
  const Plan& plan = trial.evidence.plan;
  const auto& truth = plan.truth;
  const double factor = 1.0 + truth.number("scale_factor_error"), g = gravity(*plan.site);
  const double k_oo = truth.number("second_order_oo");
  const auto add = [&](const char* name, double value) { trial.truth.emplace_back(name, value); };
  add("scale_factor", truth.number(scale_factor) * factor);
  add("bias", (truth.number("bias") + k_oo * g * g) / factor);
  for (const char* name : {"second_order_coefficient", "second_order_pp"})
    add(name, (truth.number(name) - k_oo) / factor);
  for (const char* name :
       {"third_order_coefficient", "cross_coupling_ip", "cross_coupling_io", "misalignment_o", "misalignment_p"})
    add(name, truth.number(name) / factor);
}

}  // namespace

Trial trial(std::uint64_t seed) {
  Plan plan = trial_plan("accelerometer_tumble", options(), "pendulous_accelerometer", "dividing_head", 1.0);
  set_truth(plan, coefficients);
  set_truth(plan, "bias", 3.2, "mg");
  set_truth(plan, "scale_factor_error", 450, "ppm");
  set_truth(plan, "angle_random_walk", 0.02, "(m/s)/sqrt(h)");
  set_truth(plan, "bias_instability", 2, "ug");
  set_truth(plan, "pulse_scale_factor", 2000, "pulse/s/g");
  plan.truth.set_word("output", "count");
  // each mount forwards and, between the positions taken before, back
  for (const double roll : {0.0, -90.0, 180.0, 90.0})
    for (int k = 0; k < 6; ++k) add_position(plan, roll, roll == 0.0 || roll == -90.0 ? 60.0 * k : 330.0 - 60.0 * k);
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  add_truth("pulse_scale_factor", trial);
  return trial;
}

Trial second_trial(std::uint64_t seed) {
  Plan plan = trial_plan("accelerometer_tumble", options(), "pendulous_accelerometer", "dividing_head", 2.0);
  plan.site = Site{si(-33.9, "deg"), si(18.4, "deg"), 1700.0, {}};
  for (const auto& [name, value, unit] : coefficients) set_truth(plan, name, -value, unit);
  set_truth(plan, "bias", -1.1, "mg");
  set_truth(plan, "scale_factor_error", -900, "ppm");
  set_truth(plan, "angle_random_walk", 0.01, "(m/s)/sqrt(h)");
  set_truth(plan, "bias_instability", 4, "ug");
  set_truth(plan, "voltage_scale_factor", -2.5, "V/g");
  plan.truth.set_word("output", "voltage");
  for (const double roll : {0.0, -90.0, 180.0, 90.0})
    for (const double angle : {12.0, 47.0, 101.0, 139.0, 188.0, 246.0, 290.0, 331.0})
      add_position(plan, roll, roll == 0.0 || roll == 180.0 ? angle : 360.0 - angle);
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  lose_samples(trial.evidence.recordings.front(), seed, 25);
  add_truth("voltage_scale_factor", trial);
  return trial;
}

extern const Trials trials{trial, second_trial};

}  // namespace tumble::accelerometer_tumble
