// A linear method of one's own: the drift of a rotor gyro that is constant, or proportional to the specific force along
// its input and spin axes, from positions of the tilt stand my_rig.

#include "tumble/methods/method.hpp"
#include "tumble/reduce/linear/linear.hpp"

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

Estimate answer(const linear::Solution& solution) { return linear::answer_of(solution, "deg/h", {"I", "O", "S"}); }

Estimate identify(const Evidence& evidence, const Progress&) {
  return answer(linear::identify(evidence, problem_of(evidence.plan.settings)));
}

Estimate predict(const Plan& plan) {
  return answer(linear::predict(plan, problem_of(plan.settings), linear::truth_of(plan, "gyro")));
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
    .compensates = true,
    .predict = predict};

}  // namespace tumble::my_gyro_drift
