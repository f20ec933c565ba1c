#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <memory>

#include "tumble/methods/accelerometer_centrifuge/report.hpp"
#include "tumble/methods/accelerometer_centrifuge/testing/trial.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::accelerometer_centrifuge {
namespace {

constexpr TruthValue coefficients[] = {{"bias", 3.2, "mg"},
                                       {"second_order_coefficient", 18, "ug/g^2"},
                                       {"third_order_coefficient", -0.8, "ug/g^3"},
                                       {"odd_quadratic_coefficient", 6, "ug/g^2"},
                                       {"cross_coupling_ip", 25, "ug/g^2"},
                                       {"cross_coupling_io", -14, "ug/g^2"},
                                       {"misalignment_o", 95, "arcsec"},
                                       {"misalignment_p", -60, "arcsec"},
                                       {"second_order_pp", -18, "ug/g^2"}};

void set_truth_of_unit(Plan& plan) {
  set_truth(plan, coefficients);
  set_truth(plan, "angle_random_walk", 0.02, "(m/s)/sqrt(h)");
  set_truth(plan, "bias_instability", 1, "ug");
  set_truth(plan, "pulse_scale_factor", 2000, "pulse/s/g");
  plan.truth.set_word("output", "count");
}

Motion hold(double degrees) { return {.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; }

void add_levels(Plan& plan) {
  for (const double yaw : {0.0, 180.0}) {
    const auto add = [&](const std::string& label, double seconds, const Motion& arm) {
      plan.schedule.push_back(
          {fmt::format("{}, yaw {:g}", label, yaw), seconds, 1, {{"arm", arm}, {"mount_yaw", hold(yaw)}}});
    };
    add("rest", 100.0, hold(0.0));
    for (const double speed : {163.0, 231.0, 365.0, 517.0, 633.0, 731.0})
      add(fmt::format("{:g} deg/s", speed), 120.0, {.kind = Motion::Kind::rate, .value = si(speed, "deg/s")});
    add("stop", 60.0, hold(0.0));
  }
}

Plan head_plan() {
  Plan plan = trial_plan("accelerometer_centrifuge", options(), "pendulous_accelerometer", "dividing_head", 1.0);
  set_truth_of_unit(plan);
  for (const double roll : {0.0, -90.0})
    for (int k = 0; k < 12; ++k)
      plan.schedule.push_back({fmt::format("roll {:g} at {}", roll, 30 * k),
                               60.0,
                               1,
                               {{"head", hold(30.0 * k)}, {"mount_roll", hold(roll)}}});
  return plan;
}

}  // namespace

Trial trial(std::uint64_t seed) {
  Plan plan = trial_plan("accelerometer_centrifuge", options(), "pendulous_accelerometer", "centrifuge", 1.0);
  plan.rig.set_number("radius", 1.2, Unit::parse("m"));
  // The estimator asks for the ripple at instants, which a counter averages: with more of it intervals come out wide.
  plan.rig.set_number("rate_ripple_sd", 2e-6, Unit::parse("ppm"));
  plan = with_radius_to_find(plan, 0.0);
  set_truth_of_unit(plan);
  set_setting(plan, "bias_instability", 1.0, "ug");
  add_levels(plan);
  const auto head = std::make_shared<const Plan>(head_plan());
  plan.recordings = {{"arm.h5", "", 0, nullptr}, {"head.h5", "", 0, head}};
  Plan real = plan;
  real.rig.set_number("lever_x", 1.3e-3, Unit::parse("mm"));
  real.truth.set_integer("oversampling", 64);  // a counter takes in the ripple of the arm's rate, 24 Hz at most
  real.recordings.clear();
  plan.rig.set_number("lever_sd", 1e-3, Unit::parse("mm"));  // as for a distance that is to be found
  Trial trial{{plan, {simulate(real, seed, {}), simulate(*head, seed + 1000000, {})}, {nullptr, head}}, {}};
  trial.truth.emplace_back("scale_factor", plan.truth.number("pulse_scale_factor"));
  for (const auto& coefficient : coefficients)
    trial.truth.emplace_back(coefficient.name, plan.truth.number(coefficient.name));
  trial.truth.emplace_back("effective_radius", 1.2013);
  trial.truth.emplace_back("centre_offset", 0.0);
  return trial;
}

extern const Trials trials{trial, second_trial};

}  // namespace tumble::accelerometer_centrifuge
