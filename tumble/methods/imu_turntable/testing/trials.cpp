#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/random.hpp"
#include "tumble/methods/imu_turntable/testing/trial.hpp"
#include "tumble/methods/imu_turntable/turntable.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::imu_turntable {
namespace {

Motion hold(double degrees) { return {.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; }
Motion rate(double degrees) { return {.kind = Motion::Kind::rate, .value = si(degrees, "deg/s")}; }

/// The unit with one of its axes, or an edge between two, up.
struct Pose {
  double middle, inner;
};
constexpr Pose faces[] = {{0, 0}, {0, 90}, {90, 0}, {0, 180}, {0, 270}, {-90, 0}};
constexpr Pose turned[] = {{0, 0}, {0, 90}, {90, 0}, {0, 45}, {45, 0}, {45, 90}};

void add(Plan& plan, double duration, const Motion& outer, const Pose& pose) {
  plan.schedule.push_back({fmt::format("{}", plan.schedule.size() + 1),
                           duration,
                           1,
                           {{"outer", outer}, {"middle", hold(pose.middle)}, {"inner", hold(pose.inner)}}});
}

/// Six faces up in two headings; turning both ways about the vertical with faces and edges up, fast for the levers.
void add_motions(Plan& plan) {
  for (const double heading : {0.0, 180.0})
    for (const auto& face : faces) add(plan, 24.0, hold(heading), face);
  for (const double speed : {130.0, -130.0})
    for (const auto& pose : turned) add(plan, 24.0, rate(speed), pose);
}

/// True value of each kind of term [as shown]; scaled from output to output so that no two are alike.
struct Value {
  TermKind kind;
  double value;
};
constexpr Value gyro_terms[] = {{TermKind::bias, 14.0},
                                {TermKind::scale_factor, 180.0},
                                {TermKind::misalignment, 60.0},
                                {TermKind::sensitivity, 1.5}};
constexpr Value accelerometer_terms[] = {{TermKind::bias, 2.5},
                                         {TermKind::scale_factor, 250.0},
                                         {TermKind::misalignment, -70.0},
                                         {TermKind::second_order, 22.0},
                                         {TermKind::lever, 25.0}};

void set_truth_of(Kind kind, std::size_t axis, double sign, Plan& plan) {
  double factor = sign * (axis == 1 ? -0.7 : 1.0 - 0.2 * static_cast<double>(axis));
  const auto constants = defaults(find_model("imu").constants());
  const std::span<const Value> values =
      kind == Kind::gyro ? std::span<const Value>(gyro_terms) : std::span<const Value>(accelerometer_terms);
  for (const OutputTerm& term : terms_of(kind, axis)) {
    const auto unit = linear::terms_of("imu", constants, {term.name}).front().unit;
    set_truth(plan, term.name.c_str(), factor * std::ranges::find(values, term.kind, &Value::kind)->value,
              unit.c_str());
    factor *= -0.8;
  }
}

Plan plan_with(double sign) {
  const Method& method = find_method("imu_turntable");
  Plan plan = trial_plan(method.name, method.options(), "imu", "three_axis_table", 1.0);
  add_motions(plan);
  for (const Kind kind : {Kind::gyro, Kind::accelerometer})
    for (std::size_t axis = 0; axis < 3; ++axis) set_truth_of(kind, axis, sign, plan);
  set_truth(plan, "gyro_angle_random_walk", 0.05, "deg/sqrt(h)");
  set_truth(plan, "gyro_bias_instability", 0.3, "deg/h");
  set_truth(plan, "accelerometer_angle_random_walk", 0.03, "(m/s)/sqrt(h)");
  set_truth(plan, "accelerometer_bias_instability", 5.0, "ug");
  set_setting(plan, "gyro_bias_instability", 0.3, "deg/h");
  set_setting(plan, "accelerometer_bias_instability", 5.0, "ug");
  return plan;
}

Trial trial_of(const Plan& plan, std::uint64_t seed) {
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  for (const Kind kind : {Kind::gyro, Kind::accelerometer})
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const OutputTerm& term : terms_of(kind, axis))
        trial.truth.emplace_back(term.name, plan.truth.number(term.name));
  return trial;
}

}  // namespace

Plan trial_plan() { return plan_with(1.0); }

Trial trial(std::uint64_t seed) { return trial_of(trial_plan(), seed); }

Trial second_trial(std::uint64_t seed) {
  Plan plan = plan_with(-1.0);
  plan.site = Site{.latitude = si(-51.7, "deg"), .height = 60.0, .gravity = {}, .latitude_sd = si(200.0, "arcsec")};
  std::ranges::reverse(plan.schedule);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string bias = role_of(Kind::accelerometer, axis) + "_bias";
    set_truth(plan, bias.c_str(), axis == 1 ? 330.0 : -290.0, "mg");
  }
  Trial trial = trial_of(plan, seed);
  for (Channel& channel : trial.evidence.recordings[0].channels) {
    const RandomStream lost = RandomStream(seed).split("lost").split(channel.name);
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      if (lost.uniform(i) < 0.02) channel.values[i] = std::nan("");
  }
  return trial;
}

extern const Trials trials{trial, second_trial};

}  // namespace tumble::imu_turntable
