#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <memory>

#include "tumble/methods/rlg_lock_in/testing/trial.hpp"
#include "tumble/models/lock_in.hpp"
#include "tumble/models/lock_zones.hpp"
#include "tumble/models/sagnac.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::rlg_lock_in {
namespace {

constexpr double lock_in = 0.1, dither = 15.0, frequency = 400.0, noise = 0.1;  // deg/s, deg/s, Hz, relative
constexpr double bias = 3.0, random_walk = 0.003;                               // deg/h, deg/sqrt(h)
constexpr int edges = 4;

/// Input axis along the axis of the table.
std::map<std::string, Motion> mounted() { return {{"mount_pitch", {.value = si(-90.0, "deg")}}}; }

Plan plan_of(double rate) {
  Plan plan = trial_plan("rlg_lock_in", find_method("rlg_lock_in").options(), "ring_laser_gyro", "rate_table", rate);
  plan.title = "trial of rlg_lock_in";
  plan.site = Site{.latitude = si(34.25, "deg"), .gravity = 9.7966};
  plan.settings.set_word("dither", "by_label");
  plan.settings.set_integer("edges", edges);
  plan.settings.set_number("dither_rate", si(dither, "deg/s"), Unit::parse("deg/s"));
  const auto set = [&](const char* name, double value, const char* unit) { set_truth(plan, name, value, unit); };
  plan.truth.set_integer("edges", edges);
  set("lock_in_rate", lock_in, "deg/s");
  set("bias", bias, "deg/h");
  return plan;
}

Plan sweep_plan() {
  Plan plan = plan_of(10.0);
  set_truth(plan, "angle_random_walk", random_walk, "deg/sqrt(h)");
  for (const double ratio : {0.4, 0.9, 1.1, 1.2, 1.35, 1.5, 1.75, 2.0, 2.5, 3.5, 6.0, 12.0})
    for (const double sign : {1.0, -1.0}) {
      Segment segment{fmt::format("{:+.3f} deg/s", sign * ratio * lock_in), 15.0, 1, mounted()};
      segment.axes["table"] = {.kind = Motion::Kind::rate, .value = si(sign * ratio * lock_in, "deg/s")};
      plan.schedule.push_back(std::move(segment));
    }
  return plan;
}

Plan dithered_plan() {
  Plan plan = plan_of(20.0);
  const auto set = [&](const char* name, double value, const char* unit) { set_truth(plan, name, value, unit); };
  set("dither_rate", dither, "deg/s");
  set("dither_frequency", frequency, "Hz");
  set("dither_noise", noise, "1");
  plan.schedule = {{"dithered, at rest", 20.0, 1, mounted()}};
  return plan;
}

}  // namespace

Trial trial(std::uint64_t seed) {
  Trial trial;
  const auto dithered = std::make_shared<const Plan>(dithered_plan());
  trial.evidence.plan = sweep_plan();
  trial.evidence.recordings = {simulate(trial.evidence.plan, seed, {}), simulate(*dithered, seed, {})};
  trial.evidence.plans = {nullptr, dithered};
  const LockIn lock{ring_laser_scale_factor(3, 0.1, 632.8e-9), si(lock_in, "deg/s")};
  trial.truth = {{"lock_in_rate", lock.rate},
                 {"scale_factor", lock.scale_factor},
                 {"bias", si(bias, "deg/h")},
                 {"angle_random_walk_from_lock_in",
                  angle_random_walk_from_lock_in(lock, {si(dither, "deg/s"), frequency, noise})}};
  return trial;
}

namespace {

/// The gyro of the second trial and its rates.
namespace second {
constexpr double lock_in = 0.12, dither = 10.0, frequency = 350.0, noise = 0.15;  // deg/s, deg/s, Hz, relative
constexpr double bias = -8.0, random_walk = 0.003, side = 80.0;                   // deg/h, deg/sqrt(h), mm
constexpr double ratios[] = {0.3,  -0.6, 1.07, -1.08, 1.1, -1.09, 1.13, -1.12, 1.15, -1.17, 1.2, -1.22, 1.25, -1.28,
                             1.33, -1.3, 1.4,  -1.45, 1.6, -1.55, 1.8,  -1.9,  2.3,  -2.6,  4.0, -5.0,  9.0,  -11.0};
}  // namespace second

Plan second_plan(double rate) {
  Plan plan = trial_plan("rlg_lock_in", find_method("rlg_lock_in").options(), "ring_laser_gyro", "rate_table", rate);
  plan.title = "second trial of rlg_lock_in";
  plan.site = Site{.latitude = si(-41.3, "deg"), .gravity = 9.8027};
  plan.settings.set_word("dither", "by_label");
  plan.settings.set_number("edge_margin", 0.04, Unit::parse("1"));
  plan.settings.set_number("dither_rate", si(second::dither, "deg/s"), Unit::parse("deg/s"));
  plan.settings.set_integer("edges", 2);
  plan.truth.set_integer("edges", 2);
  plan.truth.set_word("shape", "square");
  set_truth(plan, "side", second::side, "mm");
  set_truth(plan, "lock_in_rate", second::lock_in, "deg/s");
  set_truth(plan, "bias", second::bias, "deg/h");
  return plan;
}

Plan second_sweep() {
  Plan plan = second_plan(10.0);
  set_truth(plan, "angle_random_walk", second::random_walk, "deg/sqrt(h)");
  for (const double ratio : second::ratios) {
    Segment segment{fmt::format("{:+.4f} deg/s", ratio * second::lock_in), 6.0, 1, mounted()};
    segment.axes["table"] = {.kind = Motion::Kind::rate, .value = si(ratio * second::lock_in, "deg/s")};
    plan.schedule.push_back(std::move(segment));
  }
  return plan;
}

Plan second_dithered() {
  Plan plan = second_plan(17.5);
  set_truth(plan, "dither_rate", second::dither, "deg/s");
  set_truth(plan, "dither_frequency", second::frequency, "Hz");
  set_truth(plan, "dither_noise", second::noise, "1");
  plan.schedule = {{"dithered", 18.0, 1, mounted()}};
  return plan;
}

}  // namespace

Trial second_trial(std::uint64_t seed) {
  Trial trial;
  const auto dithered = std::make_shared<const Plan>(second_dithered());
  trial.evidence.plan = second_sweep();
  trial.evidence.recordings = {simulate(trial.evidence.plan, seed, {}), simulate(*dithered, seed, {})};
  trial.evidence.plans = {nullptr, dithered};
  const LockIn lock{ring_laser_scale_factor(4, si(second::side, "mm"), 632.8e-9), si(second::lock_in, "deg/s")};
  trial.truth = {
      {"lock_in_rate", lock.rate},
      {"scale_factor", lock.scale_factor},
      {"bias", si(second::bias, "deg/h")},
      {"angle_random_walk_from_lock_in",
       angle_random_walk_from_lock_in(lock, {si(second::dither, "deg/s"), second::frequency, second::noise})}};
  return trial;
}

extern const Trials trials{trial, second_trial};

}  // namespace tumble::rlg_lock_in
