// A linear method of one's own: the drift of a rotor gyro that is constant, or proportional to the specific force along
// its input and spin axes, from positions of the tilt stand my_rig.

#include "tumble/methods/method.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::my_gyro_drift {
namespace {

std::vector<Role> roles() { return {{"gyro", "deg/h", true, "output of the gyro"}}; }

std::vector<Option> options() { return linear::options("5 s", "10 s"); }

/// y = w_x + D_F + D_I f_x + D_S f_z: the terms are those of the model that simulates the gyro.
std::vector<Term> terms() {
  return linear::terms_of("sdof_gyro", defaults(find_model("sdof_gyro").constants()), {"D_F", "D_I", "D_S"});
}

linear::Problem problem_of(const Settings& settings) {
  linear::Problem problem;
  problem.role = "gyro";
  problem.input = Input::rate_x;
  problem.columns = terms();
  problem.advice = {"more_angles", "add positions at other angles of the stand"};
  linear::set_options(settings, problem);
  return problem;
}

Estimate answer(const linear::Solution& solution) {
  return linear::answer_of(solution, "my_gyro_drift", "deg/h", {"I", "O", "S"});
}

Estimate identify(const Evidence& evidence, const Progress&) {
  return answer(linear::identify(evidence, problem_of(evidence.plan.settings)));
}

Estimate predict(const Plan& plan) {
  return answer(linear::predict(plan, problem_of(plan.settings), linear::truth_of(plan, "gyro")));
}

/// Eight positions, 45 deg apart, of a gyro with known drift.
Trial trial(std::uint64_t seed) {
  Plan plan = trial_plan("my_gyro_drift", options(), "sdof_gyro", "my_rig", 1.0);
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

extern const Method my_gyro_drift{
    .name = "my_gyro_drift",
    .summary = "drift of a rotor gyro, constant and along two axes, from positions of a tilt stand",
    .source = "IEEE Std 517",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .trial = trial,
    .compensates = true,
    .predict = predict};

}  // namespace tumble::my_gyro_drift
