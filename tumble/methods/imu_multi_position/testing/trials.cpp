#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/math/random.hpp"
#include "tumble/methods/imu_multi_position/testing/trial.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::imu_multi_position {
namespace {

constexpr double poses[][3] = {  // yaw, pitch, roll [deg]: faces, edges and corners up, in all directions
    {0, 0, 0},        {100, 0, 90},   {-140, 0, 180},  {35, 0, 270},    {-90, 80, 0},     {170, -85, 20},
    {-30, 45, 0},     {120, 0, 45},   {-100, -45, 90}, {60, 40, 135},   {-160, 45, -90},  {20, -30, 225},
    {140, -40, 0},    {-60, 30, -45}, {85, 35, 45},    {-125, -35, 45}, {10, 35, 135},    {155, -35, -45},
    {-70, -35, -135}, {45, 35, 225},  {-170, 60, 100}, {110, 10, 60},   {-15, -60, -100}, {75, 0, 160}};

void set(Plan& plan, const std::string& name, double value, const char* unit) {
  plan.truth.set_number(name, si(value, unit), Unit::parse(unit));
}

void set_instrument(double sign, double offset, Plan& plan) {
  const double bias[] = {12.0, -25.0, 31.0}, scale[] = {3500.0, -2100.0, 4200.0};
  const double gyro_bias[] = {900.0, -1500.0, 400.0}, gyro_scale[] = {-6000.0, 4000.0, 2500.0};
  const double lean[3][3] = {{0, 900, -400}, {-700, 0, 1200}, {500, -300, 0}};
  const double sensitivity[3][3] = {{40, -60, 10}, {80, 20, -50}, {-30, 70, 90}};
  const std::string letters = "xyz";
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string force = fmt::format("accelerometer_{}", letters[i]), rate = fmt::format("gyro_{}", letters[i]);
    set(plan, force + "_bias", sign * (bias[i] + offset), "mg");
    set(plan, force + "_scale_factor_error", sign * scale[i], "ppm");
    set(plan, rate + "_bias", sign * gyro_bias[i], "deg/h");
    set(plan, rate + "_scale_factor_error", sign * gyro_scale[i], "ppm");
    for (std::size_t j = 0; j < 3; ++j) {
      set(plan, fmt::format("{}_acceleration_sensitivity_{}", rate, letters[j]), sign * sensitivity[i][j], "deg/h/g");
      if (i == j) continue;
      set(plan, fmt::format("{}_misalignment_{}", rate, letters[j]), sign * lean[i][j], "arcsec");
      if (j < i) set(plan, fmt::format("{}_misalignment_{}", force, letters[j]), 0.7 * sign * lean[j][i], "arcsec");
    }
  }
  set(plan, "accelerometer_resolution", 2.0, "mg");
  set(plan, "accelerometer_angle_random_walk", 0.012, "(m/s)/sqrt(h)");
  set(plan, "gyro_angle_random_walk", 1.5, "deg/sqrt(h)");
  set(plan, "accelerometer_bias_instability", 60.0, "ug");
  set(plan, "gyro_bias_instability", 15.0, "deg/h");
  set_setting(plan, "gyro_bias_instability", 15.0, "deg/h");
  set_setting(plan, "accelerometer_bias_instability", 60.0, "ug");
}

/// Pose after pose: `stride` poses further each time, all of them where it has no divisor in common with their number.
void add_poses(double seconds, std::size_t stride, Plan& plan) {
  for (std::size_t i = 0; i < std::size(poses); ++i) {
    const auto& pose = poses[i * stride % std::size(poses)];
    const auto hold = [](double degrees) { return Motion{.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; };
    plan.schedule.push_back(
        {fmt::format("rest {}", plan.schedule.size() + 1),
         seconds,
         1,
         {{"mount_yaw", hold(pose[0])}, {"mount_pitch", hold(pose[1])}, {"mount_roll", hold(pose[2])}}});
  }
}

Trial trial_of(Plan plan, std::uint64_t seed) {
  Trial trial;
  for (const auto& [name, text] : plan.truth.texts())
    for (const char* part : {"_bias", "_scale_factor_error", "_misalignment_", "_acceleration_sensitivity_"}) {
      const auto at = name.find(part);
      if (at == std::string::npos || name.find("instability") != std::string::npos) continue;
      if (name.find("_bias") != std::string::npos && !name.ends_with("_bias")) continue;
      if (!plan.truth.has(name)) continue;
      if (name == "accelerometer_x_misalignment_y" || name == "accelerometer_x_misalignment_z" ||
          name == "accelerometer_y_misalignment_z")
        continue;  // 0 by definition of the axes
      trial.truth.emplace_back(name, plan.truth.number(name));
    }
  trial.evidence.recordings.push_back(simulate(plan, seed, {}));
  trial.evidence.plan = std::move(plan);
  return trial;
}

}  // namespace

Trial trial(std::uint64_t seed, const std::vector<Option>& options) {
  Plan plan = trial_plan("imu_multi_position", options, "imu", "by_hand", 100.0);
  plan.site->gravity = 9.797;
  plan.rig.set_number("move_time", 1.4, Unit::parse("s"));
  plan.rig.set_number("gravity_sd", si(30.0, "ug"), Unit::parse("ug"));
  set_instrument(1.0, 0.0, plan);
  add_poses(4.4, 1, plan);
  return trial_of(std::move(plan), seed);
}

Trial second_trial(std::uint64_t seed, const std::vector<Option>& options) {
  Plan plan = trial_plan("imu_multi_position", options, "imu", "by_hand", 100.0);
  plan.site = Site{.latitude = si(-51.7, "deg"), .height = 60.0};
  plan.rig.set_number("move_time", 1.7, Unit::parse("s"));
  set_instrument(-1.0, 180.0, plan);
  add_poses(5.3, 7, plan);
  Trial trial = trial_of(std::move(plan), seed);
  for (Channel& channel : trial.evidence.recordings[0].channels) {
    const RandomStream lost = RandomStream(seed).split("lost").split(channel.name);
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      if (lost.uniform(i) < 0.03) channel.values[i] = std::nan("");
  }
  return trial;
}

extern const Trials trials{
    [](std::uint64_t seed) { return trial(seed, find_method("imu_multi_position").options()); },
    [](std::uint64_t seed) { return second_trial(seed, find_method("imu_multi_position").options()); }};

}  // namespace tumble::imu_multi_position
