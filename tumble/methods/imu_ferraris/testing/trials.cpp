#include "tumble/methods/testing/trials.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "tumble/math/random.hpp"
#include "tumble/methods/imu_ferraris/closed_form.hpp"
#include "tumble/methods/imu_ferraris/sections.hpp"
#include "tumble/methods/imu_ferraris/testing/trial.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::imu_ferraris {
namespace {

/// How a session is made.
struct Session {
  double pose_sd = 0.5, axis_sd = 0.5, angle_sd = 0.5;  ///< [deg]
  double gravity_sd = 30.0;                             ///< [ug]; 0: of the site
  double rate = 36.0;                                   ///< [deg/s] of the turns, ten seconds long
  double sign = 1.0;                                    ///< of all parameters
  double offset = 0.0;                                  ///< [mg] more bias of the accelerometers
  double gyro_instability = 0.0;                        ///< [deg/h]
  double accelerometer_instability = 0.0;               ///< [ug]
};
constexpr Session usual{}, other{.pose_sd = 1.0,
                                 .axis_sd = 0.8,
                                 .angle_sd = 0.3,
                                 .gravity_sd = 0.0,
                                 .rate = -72.0,
                                 .sign = -1.0,
                                 .offset = 500.0,
                                 .gyro_instability = 20.0,
                                 .accelerometer_instability = 400.0};

struct Truth {
  double bias, scale, first, second;  ///< [mg, deg/s], [%], [deg] toward the next two axes
};
constexpr Truth accelerometers[] = {{12.0, 0.8, 0.4, -0.3}, {-25.0, -1.1, 0.2, 0.6}, {18.0, 0.5, -0.5, 0.25}};
constexpr Truth gyros[] = {{0.4, 1.5, 0.7, -0.4}, {-0.25, -0.9, -0.3, 0.5}, {0.15, 0.6, 0.35, 0.2}};
constexpr double sensitivity[3][3] = {{60.0, -20.0, 30.0}, {25.0, -70.0, 15.0}, {-35.0, 20.0, 55.0}};  ///< [deg/h/g]

Motion hold(double degrees) { return {.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; }
Motion rate(double degrees) { return {.kind = Motion::Kind::rate, .value = si(degrees, "deg/s")}; }

Plan plan_on(const std::string& rig, const Session& session) {
  const Method& method = find_method("imu_ferraris");
  Plan plan = trial_plan(method.name, method.options(), "imu", rig, 50.0);
  plan.site->gravity = 9.797;
  if (session.gravity_sd > 0.0)
    plan.rig.set_number("gravity_sd", si(session.gravity_sd, "ug"), Unit::parse("ug"));
  else
    plan.site = Site{.latitude = si(-45.9, "deg"), .height = 120.0};
  const auto set = [&](imu::Kind kind, const Truth& truth, std::size_t i) {
    const bool gyro = kind == imu::Kind::gyro;
    const std::string role = imu::role_of(kind, i);
    const double sign = session.sign;
    set_truth(plan, (role + "_bias").c_str(), sign * (truth.bias + (gyro ? 0.0 : session.offset)),
              gyro ? "deg/s" : "mg");
    set_truth(plan, (role + "_scale_factor_error").c_str(), sign * 1e4 * truth.scale, "ppm");
    const double lean[]{truth.first, truth.second};
    for (std::size_t k = 0; k < 2; ++k)
      set_truth(plan, (role + "_misalignment_" + imu::letters[(i + 1 + k) % 3]).c_str(), sign * lean[k], "deg");
    for (std::size_t j = 0; gyro && j < 3; ++j)
      set_truth(plan, (role + "_acceleration_sensitivity_" + imu::letters[j]).c_str(), sign * sensitivity[i][j],
                "deg/h/g");
  };
  for (std::size_t i = 0; i < 3; ++i) {
    set(imu::Kind::accelerometer, accelerometers[i], i);
    set(imu::Kind::gyro, gyros[i], i);
  }
  set_truth(plan, "gyro_angle_random_walk", 6.0, "deg/sqrt(h)");
  set_truth(plan, "accelerometer_angle_random_walk", 0.2, "(m/s)/sqrt(h)");
  set_truth(plan, "gyro_bias_instability", session.gyro_instability, "deg/h");
  set_truth(plan, "accelerometer_bias_instability", session.accelerometer_instability, "ug");
  return plan;
}

struct Mount {
  double roll, pitch;  ///< [deg]
};
constexpr Mount up[] = {{0.0, -90.0}, {90.0, 0.0}, {0.0, 0.0}}, down[] = {{0.0, 90.0}, {-90.0, 0.0}, {180.0, 0.0}};

Plan poses_by_hand(const Session& session) {
  Plan plan = plan_on("by_hand", session);
  plan.rig.set_number("pose_sd", si(session.pose_sd, "deg"), Unit::parse("deg"));
  for (std::size_t p = 0; p < poses; ++p) {
    const Mount& mount = (sign_of(p) > 0.0 ? up : down)[axis_of(p)];
    plan.schedule.push_back({"move", 3.0, 1, {{"mount_roll", hold(mount.roll)}, {"mount_pitch", hold(mount.pitch)}}});
    plan.schedule.push_back({labels()[p], 8.0, 1, {}});
  }
  return plan;
}

/// Turns for 10 s at the rate of the session, but for what the hand adds.
Plan turns_on_table(const Session& session, const RandomStream& hand) {
  Plan plan = plan_on("rate_table", session);
  for (std::size_t t = 0; t < turns; ++t) {
    const double first = session.axis_sd * hand.normal(3 * t), second = session.axis_sd * hand.normal(3 * t + 1);
    Mount mount{up[t].roll + first, up[t].pitch + second};
    if (t == 0) {  // x is upright: pitch leans it, and roll turns where to
      const double direction = std::atan2(second, first);
      mount = {Unit::parse("deg").from_si(direction), up[t].pitch + std::hypot(first, second)};
    }
    const Segment turn{labels()[poses + t],
                       10.0,
                       1,
                       {{"table", rate(session.rate + 0.1 * session.angle_sd * hand.normal(3 * t + 2))},
                        {"mount_roll", hold(mount.roll)},
                        {"mount_pitch", hold(mount.pitch)}}};
    Segment before = turn;  // the table gathers speed
    before.label = "move";
    before.duration = 2.0;
    plan.schedule.push_back(before);
    plan.schedule.push_back(turn);
  }
  return plan;
}

void add_truth(const Plan& plan, Trial& trial) {
  const auto of = [&](const std::string& name) { return plan.truth.number(name); };
  for (const imu::Kind kind : imu::kinds)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string role = imu::role_of(kind, i);
      double row[3]{};
      for (std::size_t j = 0; j < 3; ++j)
        row[j] = j == i ? 1.0 + of(role + "_scale_factor_error") : of(role + "_misalignment_" + imu::letters[j]);
      const double k = std::hypot(row[0], row[1], row[2]);
      trial.truth.emplace_back(role + "_scale_factor", k);
      trial.truth.emplace_back(role + "_bias", of(role + "_bias"));
      for (std::size_t j = 0; j < 3; ++j)
        if (j != i) trial.truth.emplace_back(role + "_misalignment_" + imu::letters[j], row[j] / k);
      for (std::size_t j = 0; kind == imu::Kind::gyro && j < 3; ++j) {
        const std::string name = role + "_acceleration_sensitivity_" + imu::letters[j];
        trial.truth.emplace_back(name, of(name));
      }
    }
}

}  // namespace

namespace {

Trial trial_of(const Session& session, std::uint64_t seed) {
  Trial trial;
  const Plan hand = poses_by_hand(session), table = turns_on_table(session, RandomStream(seed).split("hand"));
  trial.evidence.plan = hand;
  Plan& plan = trial.evidence.plan;
  if (session.gravity_sd > 0.0) set_setting(plan, "gravity_sd", session.gravity_sd, "ug");
  set_setting(plan, "rotation_angle", 10.0 * session.rate, "deg");
  set_setting(plan, "rotation_angle_sd", session.angle_sd, "deg");
  if (session.gyro_instability > 0.0) set_setting(plan, "gyro_bias_instability", session.gyro_instability, "deg/h");
  if (session.accelerometer_instability > 0.0)
    set_setting(plan, "accelerometer_bias_instability", session.accelerometer_instability, "ug");
  trial.evidence.recordings = {simulate(hand, 2 * seed, {}), simulate(table, 2 * seed + 1, {})};
  auto turns = std::make_shared<Plan>(table);
  turns->settings = plan.settings;
  trial.evidence.plans = {nullptr, std::move(turns)};
  add_truth(hand, trial);
  return trial;
}

/// One sample in forty of every channel is lost.
void lose_samples(const RandomStream& random, Recording& recording) {
  for (Channel& channel : recording.channels) {
    const RandomStream lost = random.split(channel.name);
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      if (lost.uniform(i) < 0.025) channel.values[i] = std::nan("");
  }
}

/// The pose y_p in two parts, with something else between.
void divide_pose(Recording& recording) {
  const auto pose = std::ranges::find(recording.marks, "y_p", &Mark::label);
  const Mark mark = *pose;
  recording.marks.insert(pose + 1, {{"nothing", mark.begin + 3.0, mark.run}, {"y_p", mark.begin + 4.0, mark.run}});
}

}  // namespace

Trial trial(std::uint64_t seed) { return trial_of(usual, seed); }

Trial second_trial(std::uint64_t seed) {
  Trial trial = trial_of(other, seed);
  for (std::size_t r = 0; r < trial.evidence.recordings.size(); ++r)
    lose_samples(RandomStream(seed).split("lost").split(r), trial.evidence.recordings[r]);
  divide_pose(trial.evidence.recordings.front());
  return trial;
}

extern const Trials trials{trial, second_trial};

}  // namespace tumble::imu_ferraris
