#include "tumble/methods/method.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/linear/table_trial.hpp"
#include "tumble/reduce/sdof_gyro_support/gyro.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::sdof_gyro_dynamic {
namespace {

using linear::Problem;

std::vector<Role> roles() { return {sdof_gyro_support::gyro_role()}; }

std::vector<Option> options() {
  using Type = Option::Type;
  auto options = sdof_gyro_support::reading_options();
  for (auto& option : linear::options("2 s", "1 s")) options.push_back(std::move(option));
  options.push_back(linear::bias_instability_option("deg/h"));
  for (auto& option : linear::loop_options()) options.push_back(std::move(option));
  options.push_back({"static_terms",
                     Type::word,
                     "1",
                     "all",
                     {"none", "constant", "first", "all"},
                     "drift over specific force fitted with the rest: none, D_F, the first order, or all of (4.6)"});
  return options;
}

std::vector<std::string> static_terms(const std::string& which) {
  if (which == "none") return {};
  if (which == "constant") return {"D_F"};
  if (which == "first") return {"D_F", "D_I", "D_O", "D_S"};
  return {"D_F", "D_I", "D_O", "D_S", "D_IO", "D_OS", "D_IS", "D_II", "D_OO", "D_SS"};
}

/// y - w_I on the regressors of (4.11), with the scale factor and the misalignments that rates show besides.
Problem problem_of(const Settings& settings, const Channel* channel) {
  Problem problem;
  sdof_gyro_support::set_reading(settings, channel, problem);
  linear::set_options(settings, problem);
  linear::set_loop(settings, "sdof_gyro", problem);
  std::vector<std::string> names{"K_I",
                                 "K_O",
                                 "K_S",
                                 "K_IO",
                                 "K_OS",
                                 "K_IS",
                                 "K_II",
                                 "K_SS",
                                 "K_III",
                                 "K_ISS",
                                 "tilt_coupling",
                                 "scale_factor_error",
                                 "misalignment_O",
                                 "misalignment_S"};
  for (auto& name : static_terms(settings.word("static_terms"))) names.push_back(std::move(name));
  problem.columns = sdof_gyro_support::terms(names);
  problem.condition_limit = 1e3;  // on a table with two axes w_O' w_S is w_I w_S^2 but for the Earth rate
  problem.leave_out_first = {"D_OO", "tilt_coupling", "misalignment_S", "misalignment_O"};
  problem.advice = {"distinguish_by_rates_and_oscillations"};
  return problem;
}

/// What the method cannot know of itself.
void add_findings(const Settings& settings, Estimate& estimate) {
  const auto note = [&](const char* text) { estimate.findings.push_back({Finding::Severity::info, text, ""}); };
  if (find_parameter(estimate, "K_I")) {
    if (settings.has("natural_frequency")) {
      note(
          "K_I is what is left of the output in phase with w_I' once the lag of the loop is taken off: it is only as "
          "good as loop_lag_sd");
    } else {
      for (auto& parameter : estimate.parameters)
        if (parameter.name == "K_I") parameter.description += "; with the lag of the loop, K_I - D/k";
      estimate.findings.push_back({Finding::Severity::warning,
                                   "K_I stands for K_I - D/k: the lag D/k = 2 zeta/w_n of the rebalance loop is not "
                                   "known; give natural_frequency and damping_ratio in [settings] to take it off",
                                   ""});
    }
  }
  if (find_parameter(estimate, "K_II") || find_parameter(estimate, "K_III"))
    note(
        "K_II and K_III hold the second- and third-order non-linearity of the torquer too: rates cannot tell them "
        "apart");
}

Estimate finished(const linear::Solution& solution, const Settings& settings) {
  Estimate estimate = linear::answer_of(solution, "sdof_gyro_dynamic", "deg/h", {"I", "O", "S"}, "deg/s");
  add_findings(settings, estimate);
  return estimate;
}

Estimate identify(const Evidence& evidence, const Progress&) {
  const auto& settings = evidence.plan.settings;
  return finished(linear::identify(evidence, problem_of(settings, sdof_gyro_support::channel(evidence))), settings);
}

Estimate predict(const Plan& plan) {
  return finished(linear::predict(plan, problem_of(plan.settings, nullptr), linear::truth_of(plan, "gyro")),
                  plan.settings);
}

constexpr std::pair<const char*, double> coefficients[] = {
    {"K_I", 1e-6},     {"K_O", -1.06e-3}, {"K_S", 2e-6},   {"K_IO", -2e-6},    {"K_OS", 1e-6},
    {"K_IS", -1.6e-3}, {"K_II", 3e-6},    {"K_SS", -3e-6}, {"K_III", -1.3e-6}, {"K_ISS", 2.6e-6}};

/// Positions, rates about one and two axes, and oscillations on a two-axis table; the loop known to one per cent.
Trial trial(std::uint64_t seed) {
  Plan plan = sdof_gyro_support::trial_plan("sdof_gyro_dynamic", options(), "two_axis_table", 20.0);
  for (const auto& [name, value] : coefficients) plan.truth.set_number(name, value, Unit());
  plan.truth.set_number("natural_frequency", 92.0, Unit::parse("Hz"));
  plan.truth.set_number("damping_ratio", 0.7, Unit());
  linear::add_table_motions(plan);
  const double lag_error = 0.01 * RandomStream(seed).split("loop").normal(0);
  plan.settings.set_number("natural_frequency", 92.0 * (1.0 + lag_error), Unit::parse("Hz"));
  plan.settings.set_number("damping_ratio", 0.7, Unit());
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  for (const auto& [name, value] : coefficients) trial.truth.emplace_back(name, plan.truth.number(name));
  return trial;
}

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan) {
  return sdof_gyro_support::compensated(estimate, recording, plan, options());
}

}  // namespace

extern const Method sdof_gyro_dynamic{
    .name = "sdof_gyro_dynamic",
    .summary = "coefficients of a single-degree-of-freedom gyro over angular motion, from rates and oscillations",
    .source = "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 35-41",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .trial = trial,
    .compensate = compensate,
    .predict = predict};

}  // namespace tumble::sdof_gyro_dynamic
