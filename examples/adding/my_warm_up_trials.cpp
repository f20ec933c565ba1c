// The simulated test of my_warm_up, whose truth is known.

#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::my_warm_up {
namespace {

/// Twenty minutes with x east and twenty with x down, from power-on.
Trial trial(std::uint64_t seed) {
  Plan plan = trial_plan("my_warm_up", find_method("my_warm_up").options(), "fiber_optic_gyro", "my_rig", 1.0);
  set_truth(plan, "bias_0", 1.5, "deg/h");
  set_truth(plan, "startup_transient", -4.0, "deg/h");
  set_truth(plan, "startup_time", 250.0, "s");
  set_truth(plan, "angle_random_walk", 0.002, "deg/sqrt(h)");
  for (const double angle : {0.0, 90.0})
    plan.schedule.push_back({angle == 0.0 ? "x east" : "x down", 1200.0, 1, {{"tilt", {.value = si(angle, "deg")}}}});
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  for (const char* name : {"bias_0", "startup_transient", "startup_time"})
    trial.truth.emplace_back(name, plan.truth.number(name));
  return trial;
}

}  // namespace

extern const Trials trials{trial};

}  // namespace tumble::my_warm_up
