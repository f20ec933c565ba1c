#include "tumble/methods/north_finding/trial.hpp"

#include <fmt/format.h>

#include <memory>

#include "tumble/math/random.hpp"
#include "tumble/reduce/trial_plan.hpp"
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

}  // namespace

Trial trial(std::uint64_t seed) {
  const Method& method = find_method("north_finding");
  Plan plan = trial_plan(method.name, method.options(), "imu", "rate_table", 1.0);
  // The base leans by 3 deg, its x points to 37 deg: both as the table stands, not as it may have been set up.
  for (const char* zero : {"level_sd", "azimuth_sd", "index_zero_sd", "mount_sd"})
    plan.rig.set_number(zero, 0.0, Unit::parse("arcsec"));
  plan.rig.set_number("repeatability_sd", si(60.0, "arcsec"), Unit::parse("arcsec"));
  plan.rig.set_number("wobble_once_sd", si(20.0, "arcsec"), Unit::parse("arcsec"));
  plan.rig.set_number("axis_elevation", si(87.0, "deg"), Unit::parse("deg"));
  plan.rig.set_number("axis_azimuth", si(-53.0, "deg"), Unit::parse("deg"));
  plan.channels["gyro"] = {{"gyro_x", std::nullopt}};
  const auto set = [&](const char* name, double value, const char* unit) { set_truth(plan, name, value, unit); };
  set("gyro_x_bias", 0.35, "deg/h");
  for (const auto& part : parts) set(part.in_model, part.value, part.unit);
  set("accelerometer_x_bias", 300.0, "ug");
  set("accelerometer_y_bias", -450.0, "ug");
  set("gyro_angle_random_walk", 0.002, "deg/sqrt(h)");
  set("gyro_bias_instability", 0.002, "deg/h");
  set("accelerometer_angle_random_walk", 0.005, "(m/s)/sqrt(h)");
  set("accelerometer_bias_instability", 5.0, "ug");
  set_setting(plan, "gyro_bias_instability", 0.002, "deg/h");
  set_setting(plan, "accelerometer_bias_instability", 5.0, "ug");
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

}  // namespace tumble::north_finding
