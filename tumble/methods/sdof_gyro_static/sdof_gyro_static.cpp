#include "tumble/methods/method.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/sdof_gyro_support/gyro.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::sdof_gyro_static {
namespace {

using linear::Problem;

std::vector<Role> roles() { return {sdof_gyro_support::gyro_role()}; }

std::vector<Option> options() {
  using Type = Option::Type;
  auto options = sdof_gyro_support::reading_options();
  for (auto& option : linear::options("5 s", "10 s")) options.push_back(std::move(option));
  options.push_back(linear::bias_instability_option("deg/h"));
  options.push_back({"misalignment",
                     Type::flag,
                     "1",
                     "false",
                     {},
                     "true: the angles of the input axis toward O and S are parameters too; take each position at two "
                     "opposite azimuths"});
  options.push_back(
      {"drift", Type::flag, "1", "false", {}, "true: a drift linear in the time since power-on is a parameter too"});
  return options;
}

Term drift_rate() {
  return {"drift_rate", "dw/dt", "deg/h/h", "drift linear in the time since power-on",
          [](const Felt& felt) { return felt.since_power_on; }};
}

/// y - w_I = row(f) . D, docs/equations (4.6); Earth rate along the input axis is the known input.
Problem problem_of(const Settings& settings, const Channel* channel) {
  Problem problem;
  sdof_gyro_support::set_reading(settings, channel, problem);
  linear::set_options(settings, problem);
  std::vector<std::string> names{"D_F", "D_I", "D_O", "D_S", "D_IO", "D_OS", "D_IS", "D_II", "D_OO", "D_SS"};
  problem.leave_out_first = {"D_OO"};
  if (settings.flag("misalignment"))
    for (const char* name : {"misalignment_O", "misalignment_S"}) {
      names.emplace_back(name);
      problem.leave_out_first.emplace_back(name);
    }
  problem.columns = sdof_gyro_support::terms(names);
  if (settings.flag("drift")) problem.columns.push_back(drift_rate());
  problem.advice = {"distinguish_static_drift"};
  return problem;
}

Estimate finished(const linear::Solution& solution) {
  Estimate estimate = linear::answer_of(solution, "sdof_gyro_static", "deg/h", {"I", "O", "S"});
  sdof_gyro_support::add_repeats(solution, estimate);
  return estimate;
}

Estimate identify(const Evidence& evidence, const Progress&) {
  return finished(linear::identify(evidence, problem_of(evidence.plan.settings, sdof_gyro_support::channel(evidence))));
}

Estimate predict(const Plan& plan) {
  return finished(linear::predict(plan, problem_of(plan.settings, nullptr), linear::truth_of(plan, "gyro")));
}

/// 6 faces, 12 edges and 8 corners in a mixed order, the first again at the end, on a two-axis table.
Trial trial(std::uint64_t seed) {
  Plan plan = sdof_gyro_support::trial_plan("sdof_gyro_static", options(), "two_axis_table", 1.0);
  for (const auto& position : sdof_gyro_support::cube_positions())
    plan.schedule.push_back(sdof_gyro_support::at(position, 100.0));
  plan.schedule.push_back(plan.schedule.front());
  plan.schedule.back().label += " again";
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  for (const char* name : {"D_F", "D_I", "D_O", "D_S", "D_IO", "D_OS", "D_IS", "D_II", "D_SS"})
    trial.truth.emplace_back(name, plan.truth.number(name));
  return trial;
}

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan) {
  return sdof_gyro_support::compensated(estimate, recording, plan, options(), {drift_rate()});
}

}  // namespace

extern const Method sdof_gyro_static{
    .name = "sdof_gyro_static",
    .summary = "drift coefficients of a single-degree-of-freedom gyro over specific force, from positions",
    .source = "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 28-34",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .trial = trial,
    .compensate = compensate,
    .predict = predict};

}  // namespace tumble::sdof_gyro_static
