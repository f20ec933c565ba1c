#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "tumble/earth/earth.hpp"
#include "tumble/math/matrix3.hpp"
#include "tumble/math/random.hpp"
#include "tumble/methods/imu_channel_calibration/calibration.hpp"
#include "tumble/methods/imu_channel_calibration/testing/trial.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::imu_channel_calibration {
namespace {

/// Bias [mg, deg/h], scale factor error [ppm], misalignments [arcsec] of each channel as the instrument has them.
struct Truth {
  double bias, scale, first, second;
};
constexpr Truth accelerometers[] = {{2.5, 150.0, 60.0, -40.0}, {-1.8, -220.0, 35.0, 50.0}, {0.9, 310.0, -25.0, 15.0}};
constexpr Truth gyros[] = {{12.0, 80.0, 45.0, -30.0}, {-8.0, -120.0, 20.0, 55.0}, {5.0, 200.0, -35.0, 10.0}};
constexpr double second_order = 15.0;  ///< [ug/g^2]

/// What all parts of a trial share.
struct Common {
  double sign = 1.0;  ///< of all parameters
  Site site;
  double gravity_error = 0.0, latitude_error = 0.0;  ///< [m/s^2], [rad]: the site was surveyed once for all parts
};

Common common_of(double sign, const Site& site, std::uint64_t seed) {
  const auto drawn = [&](const char* what) { return RandomStream(seed).split(what).normal(0); };
  return {sign, site, gravity_sd(site) * drawn("gravity of the site"), latitude_sd(site) * drawn("latitude")};
}

Motion hold(double degrees) { return {.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; }
Motion rate(double degrees) { return {.kind = Motion::Kind::rate, .value = si(degrees, "deg/s")}; }

void set_channel(Plan& plan, Kind kind, std::size_t axis, double sign) {
  const bool gyro = kind == Kind::gyro;
  const Truth& of = (gyro ? gyros : accelerometers)[axis];
  const std::string role = role_of(kind, axis);
  const auto set = [&](const std::string& name, double value, const char* unit) {
    set_truth(plan, (role + name).c_str(), sign * value, unit);
  };
  set("_bias", of.bias, gyro ? "deg/h" : "mg");
  set("_scale_factor_error", of.scale, "ppm");
  set(fmt::format("_misalignment_{}", letters[other_axis(axis, 2)]), of.first, "arcsec");
  set(fmt::format("_misalignment_{}", letters[other_axis(axis, 3)]), of.second, "arcsec");
  if (!gyro) set("_second_order_coefficient", second_order, "ug/g^2");
}

void count_gyros(Plan& plan) {
  plan.truth.set_word("gyro_output", "count");
  set_truth(plan, "gyro_pulse_scale_factor", 10.0, "pulse/arcsec");
  set_truth(plan, "gyro_angle_random_walk", 0.005, "deg/sqrt(h)");
  set_truth(plan, "gyro_bias_instability", 0.004, "deg/h");
  plan.rig.set_number("rate_ripple_sd", si(0.5, "ppm"), Unit::parse("ppm"));
}

Plan whole_plan(const Method& method, const Common& common) {
  Plan plan = trial_plan(method.name, method.options(), "imu", "two_axis_table", 10.0);
  plan.site = common.site;
  plan.settings.set_word("accelerometer_scale_factor", "10000 pulse/s/g");
  plan.settings.set_word("gyro_scale_factor", "10 pulse/arcsec");
  plan.settings.set_number("assembly_sd", si(60.0, "arcsec"), Unit::parse("arcsec"));
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const Kind kind : kinds) set_channel(plan, kind, axis, common.sign);
  count_gyros(plan);
  plan.truth.set_word("accelerometer_output", "count");
  set_truth(plan, "accelerometer_pulse_scale_factor", 10000.0, "pulse/s/g");
  set_truth(plan, "accelerometer_angle_random_walk", 0.005, "(m/s)/sqrt(h)");
  set_truth(plan, "accelerometer_bias_instability", 0.5, "ug");
  const auto add = [&](const std::string& label, double duration, const Motion& outer, const Motion& inner) {
    plan.schedule.push_back({label, duration, 1, {{"outer", outer}, {"inner", inner}}});
  };
  const double faces[][2] = {{0, 0},   {90, 0},   {90, 90},   {90, 180}, {90, 270}, {180, 0},  {45, 0},
                             {45, 90}, {135, 45}, {135, 180}, {90, 45},  {90, 135}, {90, 225}, {90, 315}};
  for (const auto& face : faces)
    add(fmt::format("face {:g} {:g}", face[0], face[1]), 60.0, hold(face[0]), hold(face[1]));
  for (const double speed : {30.0, -30.0}) {
    add(fmt::format("x at {:g}", speed), 40.0, rate(speed), hold(0.0));
    add(fmt::format("y at {:g}", speed), 40.0, rate(speed), hold(90.0));
    add(fmt::format("z at {:g}", speed), 40.0, hold(0.0), rate(speed));
  }
  const double checks[][2] = {{45, 30}, {135, 120}, {60, 250}};
  for (const auto& face : checks)
    add(fmt::format("check {:g} {:g}", face[0], face[1]), 40.0, hold(face[0]), hold(face[1]));
  return plan;
}

/// One accelerometer of the unit on its own: input axis along x, four positions ten times.
Plan accelerometer_plan(std::size_t axis, const Common& common) {
  Plan plan = trial_plan("", {}, "pendulous_accelerometer", "dividing_head", 1.0);
  plan.site = common.site;
  plan.channels[role_of(Kind::accelerometer, axis)] = {{"accelerometer", std::nullopt}};
  const Truth& of = accelerometers[axis];
  plan.truth.set_word("output", "count");
  set_truth(plan, "pulse_scale_factor", 10000.0, "pulse/s/g");
  set_truth(plan, "bias", common.sign * of.bias, "mg");
  set_truth(plan, "scale_factor_error", common.sign * of.scale, "ppm");
  set_truth(plan, "second_order_coefficient", common.sign * second_order, "ug/g^2");
  set_truth(plan, "angle_random_walk", 0.005, "(m/s)/sqrt(h)");
  set_truth(plan, "bias_instability", 0.5, "ug");
  for (int turn = 1; turn <= 10; ++turn)
    for (int k = 1; k <= 4; ++k) {
      const int position = turn % 2 == 1 ? k : 5 - k;  // and back again, so that the head never goes far

      plan.schedule.push_back(
          {fmt::format("{} turn {}", position, turn), 40.0, 1, {{"head", hold(180.0 - 90.0 * position)}}});
    }
  return plan;
}

/// One gyro on a rate table, its input axis along the table's.
Plan gyro_plan(std::size_t axis, const Common& common) {
  Plan plan = trial_plan("", {}, "triad", "rate_table", 10.0);
  plan.site = common.site;
  plan.truth.set_word("sensors", "gyros");
  plan.channels[role_of(Kind::gyro, axis)] = {{role_of(Kind::gyro, axis), std::nullopt}};
  set_channel(plan, Kind::gyro, axis, common.sign);
  // alone, it is mounted by its own input axis, which does not lean
  for (const std::size_t which : {2u, 3u})
    set_truth(plan,
              fmt::format("{}_misalignment_{}", role_of(Kind::gyro, axis), letters[other_axis(axis, which)]).c_str(),
              0.0, "arcsec");
  count_gyros(plan);
  for (const double speed : {0.0, 30.0, -30.0, 60.0, -60.0, 45.0, -45.0, 15.0, -15.0, 75.0, -75.0, 90.0, -90.0}) {
    Segment segment{fmt::format("{:g} deg/s", speed), 40.0, 1, {{"table", speed == 0.0 ? hold(0.0) : rate(speed)}}};
    segment.axes["mount_pitch"] = hold(axis == 0 ? -90.0 : 0.0);
    segment.axes["mount_roll"] = hold(axis == 1 ? 90.0 : 0.0);
    plan.schedule.push_back(segment);
  }
  return plan;
}

/// nabla, dK and E of (3.4) from what the instrument has: M = (1 + S)^-1, nabla = M b.
void add_truth(Kind kind, double sign, Trial& trial) {
  const bool gyro = kind == Kind::gyro;
  const auto& all = gyro ? gyros : accelerometers;
  Matrix3 s = identity3();
  Vector3 b;
  for (std::size_t i = 0; i < 3; ++i) {
    b[i] = sign * si(all[i].bias, gyro ? "deg/h" : "mg");
    s(i, i) += sign * si(all[i].scale, "ppm");
    s(i, other_axis(i, 2)) = sign * si(all[i].first, "arcsec");
    s(i, other_axis(i, 3)) = sign * si(all[i].second, "arcsec");
  }
  const Matrix3 m = inverse(s);
  const Vector3 nabla = m * b;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string role = role_of(kind, i);
    const double scale = sign * si(all[i].scale, "ppm"), dk = 1.0 / (1.0 + scale) - 1.0, alone = b[i] / (1.0 + scale);
    trial.truth.emplace_back(role + "_bias", nabla[i]);
    trial.truth.emplace_back(role + "_scale_factor_error", m(i, i) - 1.0);
    trial.truth.emplace_back(fmt::format("{}_misalignment_{}", role, letters[other_axis(i, 2)]),
                             m(i, other_axis(i, 2)));
    trial.truth.emplace_back("split." + role + "_bias", alone);
    trial.truth.emplace_back("split." + role + "_scale_factor_error", dk);
    trial.truth.emplace_back("whole_minus_split." + role + "_bias", nabla[i] - alone);
    trial.truth.emplace_back("whole_minus_split." + role + "_scale_factor_error", m(i, i) - 1.0 - dk);
  }
}

/// One draw for all parts replaces the errors of gravity and latitude of each rig.
Recording simulated(Plan plan, std::uint64_t seed, const Common& common) {
  plan.site->gravity = gravity(*plan.site) + common.gravity_error;
  plan.rig.set_number("gravity_sd", 0.0, Unit::parse("ug"));
  plan.site->latitude += common.latitude_error;
  plan.site->latitude_sd = 0.0;
  return simulate(plan, seed, {});
}

void add_part(Plan part, std::uint64_t seed, const Common& common, Trial& trial) {
  trial.evidence.recordings.push_back(simulated(part, seed, common));
  trial.evidence.plans.push_back(std::make_shared<const Plan>(std::move(part)));
}

Trial trial_of(const Common& common, std::uint64_t seed) {
  Trial trial;
  trial.evidence.plan = whole_plan(find_method("imu_channel_calibration"), common);
  trial.evidence.recordings.push_back(simulated(trial.evidence.plan, seed * 16, common));
  trial.evidence.plans.push_back(nullptr);
  for (std::size_t axis = 0; axis < 3; ++axis)
    add_part(accelerometer_plan(axis, common), seed * 16 + 1 + axis, common, trial);
  for (std::size_t axis = 0; axis < 3; ++axis) add_part(gyro_plan(axis, common), seed * 16 + 4 + axis, common, trial);
  for (const Kind kind : kinds) add_truth(kind, common.sign, trial);
  return trial;
}

}  // namespace

Trial trial(std::uint64_t seed) {
  const Site site{.latitude = si(34.25, "deg"), .height = 400.0, .gravity = 9.797};
  return trial_of(common_of(1.0, site, seed), seed);
}

Trial second_trial(std::uint64_t seed) {
  const Site site{.latitude = si(-33.9, "deg"), .height = 25.0, .gravity = {}, .latitude_sd = si(120.0, "arcsec")};
  Trial trial = trial_of(common_of(-1.0, site, seed), seed);
  for (std::size_t r = 0; r < trial.evidence.recordings.size(); ++r)
    for (Channel& channel : trial.evidence.recordings[r].channels) {
      const RandomStream lost = RandomStream(seed).split("lost").split(r).split(channel.name);
      for (std::size_t i = 0; i < channel.values.size(); ++i)
        if (lost.uniform(i) < 0.005) channel.values[i] = std::nan("");
    }
  return trial;
}

extern const Trials trials{trial, second_trial};

}  // namespace tumble::imu_channel_calibration
