#include <fmt/format.h>

#include <limits>
#include <memory>

#include "tumble/methods/accelerometer_centrifuge/report.hpp"
#include "tumble/methods/accelerometer_centrifuge/testing/trial.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/constants.hpp"

// What the first trial holds at zero or ideal: an effective centre off the mounting's, the arm in both senses of
// turning, another site and radius, a repeated level, a gap; the sign of every coefficient is turned.
namespace tumble::accelerometer_centrifuge {
namespace {

constexpr double centre = -2.5e-3, shorter = -3.1e-3, second_radius = 0.85;  // m
constexpr TruthValue second_coefficients[] = {{"bias", -2.1, "mg"},
                                              {"second_order_coefficient", -22, "ug/g^2"},
                                              {"third_order_coefficient", 1.5, "ug/g^3"},
                                              {"odd_quadratic_coefficient", -9, "ug/g^2"},
                                              {"cross_coupling_ip", -18, "ug/g^2"},
                                              {"cross_coupling_io", 20, "ug/g^2"},
                                              {"misalignment_o", -70, "arcsec"},
                                              {"misalignment_p", 110, "arcsec"},
                                              {"second_order_pp", 12, "ug/g^2"}};

void set_second_truth(Plan& plan) {
  plan.site = Site{si(-33.9, "deg"), si(18.6, "deg"), 40.0, {}};
  set_truth(plan, second_coefficients);
  set_truth(plan, "angle_random_walk", 0.02, "(m/s)/sqrt(h)");
  set_truth(plan, "bias_instability", 1, "ug");
  set_truth(plan, "voltage_scale_factor", 0.25, "V/g");
  plan.truth.set_word("output", "voltage");
}

Motion held(double degrees) { return {.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; }

void add_second_levels(Plan& plan) {
  for (const double yaw : {0.0, 180.0}) {
    const auto add = [&](const std::string& label, double seconds, const Motion& arm) {
      plan.schedule.push_back(
          {fmt::format("{}, yaw {:g}", label, yaw), seconds, 1, {{"arm", arm}, {"mount_yaw", held(yaw)}}});
    };
    add("rest", 100.0, held(0.0));
    for (const double speed : {-200.0, -350.0, 500.0, 640.0, -750.0, 860.0, 500.0})
      add(fmt::format("{:g} deg/s{}", speed, plan.schedule.back().label.starts_with("860") ? " again" : ""), 120.0,
          Motion{.kind = Motion::Kind::rate, .value = si(speed, "deg/s")});
    add("stop", 80.0, held(0.0));
  }
}

Plan tumble_plan() {
  Plan plan = trial_plan("accelerometer_centrifuge", options(), "pendulous_accelerometer", "dividing_head", 1.0);
  set_second_truth(plan);
  for (const double roll : {0.0, 90.0})
    for (int k = 0; k < 8; ++k)
      plan.schedule.push_back({fmt::format("roll {:g} at {}", roll, 45 * k),
                               60.0,
                               1,
                               {{"head", held(45.0 * k)}, {"mount_roll", held(roll)}}});
  return plan;
}

/// The arm, with the effective centre out along the input axis: further from the arm's axis at yaw 0, and nearer to it
/// at yaw 180.
Recording on_the_arm(Plan plan, std::uint64_t seed) {
  plan.recordings.clear();
  plan.truth.set_integer("oversampling", 32);
  const auto with_lever = [&](double lever) {
    plan.rig.set_number("lever_x", lever, Unit::parse("mm"));
    return simulate(plan, seed, {});
  };
  Recording recording = with_lever(shorter + centre);
  const Recording turned = with_lever(shorter - centre);
  Channel& output = recording.channels.front();
  const auto half = index_at(output, recording.marks[recording.marks.size() / 2].begin);
  for (std::size_t i = half; i < output.values.size(); ++i) output.values[i] = turned.channels.front().values[i];
  const std::size_t lost = index_at(output, recording.marks[4].begin) + 60;
  for (std::size_t i = lost; i < lost + 15; ++i) output.values[i] = std::numeric_limits<double>::quiet_NaN();
  return recording;
}

}  // namespace

Trial second_trial(std::uint64_t seed) {
  Plan plan = trial_plan("accelerometer_centrifuge", options(), "pendulous_accelerometer", "centrifuge", 1.0);
  plan.rig.set_number("radius", second_radius, Unit::parse("m"));
  plan.rig.set_number("rate_ripple_sd", 2e-6, Unit::parse("ppm"));  // see the first trial
  plan = with_radius_to_find(plan, 0.0);
  set_second_truth(plan);
  set_setting(plan, "bias_instability", 1.0, "ug");
  add_second_levels(plan);
  const auto tumble = std::make_shared<const Plan>(tumble_plan());
  plan.recordings = {{"arm.h5", "", 0, nullptr}, {"tumble.h5", "", 0, tumble}};
  Trial trial{{plan, {on_the_arm(plan, seed), simulate(*tumble, seed + 1000000, {})}, {nullptr, tumble}}, {}};
  // as for a distance that is to be found
  trial.evidence.plan.rig.set_number("lever_sd", si(2.0, "mm"), Unit::parse("mm"));
  trial.truth.emplace_back("scale_factor", plan.truth.number("voltage_scale_factor"));
  for (const auto& coefficient : second_coefficients)
    trial.truth.emplace_back(coefficient.name, plan.truth.number(coefficient.name));
  trial.truth.emplace_back("effective_radius", second_radius + shorter);
  trial.truth.emplace_back("centre_offset", centre);
  return trial;
}

}  // namespace tumble::accelerometer_centrifuge
