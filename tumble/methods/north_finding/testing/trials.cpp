#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <string_view>

#include "tumble/math/random.hpp"
#include "tumble/methods/north_finding/testing/trial.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::north_finding {
namespace {

/// Forwards and back: a drift of the bias cancels.
constexpr double angles[] = {0.0, 90.0, 180.0, 270.0, 270.0, 180.0, 90.0, 0.0};

void add_schedule(Plan& plan) {
  int number = 0;
  for (const double angle : angles)
    plan.schedule.push_back(
        {fmt::format("{} at {}", ++number, angle),
         150.0,
         1,
         {{"table", {.kind = Motion::Kind::slew, .value = si(20.0, "deg/s"), .to = si(angle, "deg")}}}});
}

struct True {
  const char* name;  ///< in the calibration
  const char* unit;
  const char* in_model;  ///< in the truth of the imu
  double value, sd;
};

constexpr True parts[] = {{"gyro.misalignment_y", "arcsec", "gyro_x_misalignment_y", 180.0, 30.0},
                          {"gyro.misalignment_z", "arcsec", "gyro_x_misalignment_z", -90.0, 20.0},
                          {"accelerometer_x.misalignment_y", "arcsec", "accelerometer_x_misalignment_y", 60.0, 20.0},
                          {"accelerometer_x.misalignment_z", "arcsec", "accelerometer_x_misalignment_z", -45.0, 10.0},
                          {"accelerometer_y.misalignment_x", "arcsec", "accelerometer_y_misalignment_x", -70.0, 20.0},
                          {"accelerometer_y.misalignment_z", "arcsec", "accelerometer_y_misalignment_z", 50.0, 10.0}};

/// A calibration by another test: its errors are drawn from its covariance.
std::shared_ptr<const Estimate> calibration(std::uint64_t seed) {
  auto result = std::make_shared<Estimate>();
  const RandomStream random = RandomStream(seed).split("calibration");
  const std::size_t n = std::size(parts);
  result->method = "rlg_north_finder";
  result->covariance = Matrix(n, n);
  for (std::size_t k = 0; k < n; ++k) {
    const double sd = si(parts[k].sd, parts[k].unit);
    result->covariance(k, k) = sd * sd;
    result->parameters.push_back(
        {parts[k].name, "", Unit::parse(parts[k].unit), si(parts[k].value, parts[k].unit) + sd * random.normal(k), ""});
  }
  return result;
}

/// A table whose base leans, its x to an azimuth: both as the table stands, not as it may have been set up.
Plan plan_on_table() {
  const Method& method = find_method("north_finding");
  Plan plan = trial_plan(method.name, method.options(), "imu", "rate_table", 1.0);
  for (const char* zero : {"level_sd", "azimuth_sd", "index_zero_sd", "mount_sd"})
    plan.rig.set_number(zero, 0.0, Unit::parse("arcsec"));
  plan.channels["gyro"] = {{"gyro_x", std::nullopt}};
  set_truth(plan, "gyro_angle_random_walk", 0.002, "deg/sqrt(h)");
  set_truth(plan, "gyro_bias_instability", 0.002, "deg/h");
  set_truth(plan, "accelerometer_angle_random_walk", 0.005, "(m/s)/sqrt(h)");
  set_truth(plan, "accelerometer_bias_instability", 5.0, "ug");
  set_setting(plan, "gyro_bias_instability", 0.002, "deg/h");
  set_setting(plan, "accelerometer_bias_instability", 5.0, "ug");
  return plan;
}

/// Twelve stays by hand, there and back, at angles that nobody would command.
void add_stays_by_hand(const RandomStream& hand, Plan& plan, Plan& carried_out) {
  constexpr double odd_angles[] = {0.0, 45.0, 135.0, 180.0, 225.0, 315.0, 315.0, 225.0, 180.0, 135.0, 45.0, 0.0};
  for (std::size_t k = 0; k < std::size(odd_angles); ++k) {
    Motion motion{.kind = Motion::Kind::slew, .value = si(15.0, "deg/s"), .to = si(odd_angles[k], "deg")};
    plan.schedule.push_back({fmt::format("{} at {}", k + 1, odd_angles[k]), 120.0, 1, {{"table", motion}}});
    motion.to += si(0.4, "deg") * hand.normal(k);
    carried_out.schedule.push_back(plan.schedule.back());
    carried_out.schedule.back().axes.at("table") = motion;
  }
}

}  // namespace

Trial second_trial(std::uint64_t seed) {
  Plan plan = plan_on_table();
  plan.site = Site{.latitude = si(-45.9, "deg"), .height = 30.0, .gravity = {}, .latitude_sd = si(100.0, "arcsec")};
  plan.rig.set_number("axis_elevation", si(88.5, "deg"), Unit::parse("deg"));
  plan.rig.set_number("axis_azimuth", si(151.0, "deg"), Unit::parse("deg"));
  set_truth(plan, "gyro_x_bias", -0.6, "deg/h");
  set_truth(plan, "accelerometer_x_bias", -700.0, "ug");
  set_truth(plan, "accelerometer_y_bias", 250.0, "ug");
  set_setting(plan, "gyro_misalignment_sd", 60.0, "arcsec");
  set_setting(plan, "accelerometer_misalignment_sd", 40.0, "arcsec");
  const RandomStream drawn = RandomStream(seed).split("instrument");
  for (std::size_t k = 0; k < std::size(parts); ++k) {
    const double sd = std::string_view(parts[k].name).starts_with("gyro") ? 60.0 : 40.0;
    set_truth(plan, parts[k].in_model, sd * drawn.normal(k), "arcsec");
  }
  Plan carried_out = plan;
  add_stays_by_hand(RandomStream(seed).split("hand"), plan, carried_out);
  Trial trial{{plan, {simulate(carried_out, seed, {})}, {}}, {}};
  for (tumble::Channel& channel : trial.evidence.recordings[0].channels) {
    const RandomStream lost = RandomStream(seed).split("lost").split(channel.name);
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      if (lost.uniform(i) < 0.02) channel.values[i] = std::nan("");
  }
  // At index 0 the x of the rate table is level, 90 deg to the right of where the axis leans: y points down.
  trial.truth = {{"azimuth", si(241.0, "deg")}, {"pitch", 0.0}, {"roll", si(-1.5, "deg")}};
  return trial;
}

Trial trial(std::uint64_t seed) {
  Plan plan = plan_on_table();
  plan.rig.set_number("repeatability_sd", si(60.0, "arcsec"), Unit::parse("arcsec"));
  plan.rig.set_number("wobble_once_sd", si(20.0, "arcsec"), Unit::parse("arcsec"));
  plan.rig.set_number("axis_elevation", si(87.0, "deg"), Unit::parse("deg"));
  plan.rig.set_number("axis_azimuth", si(-53.0, "deg"), Unit::parse("deg"));
  const auto set = [&](const char* name, double value, const char* unit) { set_truth(plan, name, value, unit); };
  set("gyro_x_bias", 0.35, "deg/h");
  for (const auto& part : parts) set(part.in_model, part.value, part.unit);
  set("accelerometer_x_bias", 300.0, "ug");
  set("accelerometer_y_bias", -450.0, "ug");
  add_schedule(plan);
  plan.calibration = {"calibration.json", "", calibration(seed)};
  Trial trial{{plan, {simulate(plan, seed, {})}, {}}, {}};
  // Without the encoder the index angles are as uncertain as the table goes to them.
  std::erase_if(trial.evidence.recordings[0].channels,
                [](const tumble::Channel& output) { return output.name == "table_angle"; });
  // At index 0 the x of the rate table is level, 90 deg to the right of where the axis leans: y points down.
  trial.truth = {{"azimuth", si(37.0, "deg")}, {"pitch", 0.0}, {"roll", si(-3.0, "deg")}};
  return trial;
}

extern const Trials trials{trial, second_trial};

}  // namespace tumble::north_finding
