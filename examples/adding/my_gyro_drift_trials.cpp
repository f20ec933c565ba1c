// The simulated test of my_gyro_drift, whose truth is known.

#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::my_gyro_drift {
namespace {

/// Eight positions, 45 deg apart, of a gyro with known drift.
Trial trial(std::uint64_t seed) {
  Plan plan = trial_plan("my_gyro_drift", find_method("my_gyro_drift").options(), "sdof_gyro", "my_rig", 1.0);
  set_truth(plan, "D_F", 1.8, "deg/h");
  set_truth(plan, "D_I", 2.5, "deg/h/g");
  set_truth(plan, "D_S", -1.2, "deg/h/g");
  set_truth(plan, "angle_random_walk", 0.002, "deg/sqrt(h)");
  for (int k = 0; k < 8; ++k) {
    const double angle = 45.0 * k;
    plan.schedule.push_back({std::to_string(45 * k) + " deg", 300.0, 1, {{"tilt", {.value = si(angle, "deg")}}}});
  }
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  for (const char* name : {"D_F", "D_I", "D_S"}) trial.truth.emplace_back(name, plan.truth.number(name));
  return trial;
}

}  // namespace

extern const Trials trials{trial};

}  // namespace tumble::my_gyro_drift
