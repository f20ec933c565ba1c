#include "tumble/methods/linear_method.hpp"
#include "tumble/reduce/linear/table_trial.hpp"
#include "tumble/reduce/sdof_gyro_support/gyro.hpp"
#include "tumble/reduce/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::sdof_gyro_dynamic {
namespace {

std::vector<Option> options() {
  auto options = sdof_gyro_support::options("2 s", "1 s");
  for (auto& option : linear::loop_options()) options.push_back(std::move(option));
  options.push_back(
      word("static_terms", {"none", "constant", "first", "all"})
          .otherwise("all")
          .says("drift over specific force that is fitted too: none, D_F, the first order, or all of (4.6)"));
  return options;
}

std::vector<std::string> static_terms(const std::string& which) {
  if (which == "none") return {};
  if (which == "constant") return {"D_F"};
  return which == "first" ? sdof_gyro_support::first_order_terms() : sdof_gyro_support::drift_terms();
}

/// y - w_I on the regressors of (4.11), with the scale factor and the misalignments, which rates show too.
linear::Problem problem_of(const Settings& settings, const Channel* channel) {
  auto problem = sdof_gyro_support::problem_of(settings, channel);
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
  problem.condition_limit = 1e3;  // on a table with two axes w_O' w_S is w_I w_S^2, except for the Earth rate
  problem.leave_out_first = {"D_OO", "tilt_coupling", "misalignment_S", "misalignment_O"};
  problem.advice = {"distinguish_by_rates_and_oscillations"};
  return problem;
}

void add_findings(const Settings& settings, Estimate& estimate) {
  const auto has = [&](const char* name) { return find_parameter(estimate, name) != nullptr; };
  if (has("K_I")) {
    const bool known = settings.has("natural_frequency");
    estimate.findings.push_back({known ? Finding::Severity::info : Finding::Severity::warning,
                                 known ? "K_I_rests_on_the_lag" : "K_I_holds_the_lag",
                                 {}});
    for (auto& parameter : estimate.parameters)
      if (!known && parameter.name == "K_I") parameter.description += "; with the lag of the loop, K_I - D/k";
  }
  if (has("K_II") || has("K_III"))
    estimate.findings.push_back({Finding::Severity::info, "torquer_in_K_II_and_K_III", {}});
}

Estimate finished(const linear::Solution& solution, const Settings& settings) {
  Estimate estimate = linear::answer_of(solution, "sdof_gyro_dynamic", "deg/h", {"I", "O", "S"}, "deg/s");
  add_findings(settings, estimate);
  return estimate;
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
  plan.truth.set_integer("oversampling", 8);  // the simulated loop is solved for parabolas through three steps
  linear::add_table_motions(plan);
  const double lag_error = 0.01 * RandomStream(seed).split("loop").normal(0);
  plan.settings.set_number("natural_frequency", 92.0 * (1.0 + lag_error), Unit::parse("Hz"));
  plan.settings.set_number("damping_ratio", 0.7, Unit());
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  for (const auto& [name, value] : coefficients) trial.truth.emplace_back(name, plan.truth.number(name));
  return trial;
}

/// Coefficients of the other sign, a slower loop with less damping, other speeds and oscillations on a table whose axis
/// is tilted, at another site; a current, with samples missing.
Trial second_trial(std::uint64_t seed) {
  Plan plan = sdof_gyro_support::trial_plan("sdof_gyro_dynamic", options(), "two_axis_table", 25.0);
  plan.site = Site{si(-33.9, "deg"), si(18.4, "deg"), 1700.0, {}};
  plan.rig.set_number("outer_azimuth", si(37.0, "deg"), Unit::parse("deg"));
  plan.rig.set_number("outer_elevation", si(20.0, "deg"), Unit::parse("deg"));
  for (const auto& [name, value] : coefficients) plan.truth.set_number(name, -1.5 * value, Unit());
  plan.truth.set_number("natural_frequency", 55.0, Unit::parse("Hz"));
  plan.truth.set_number("damping_ratio", 0.5, Unit());
  plan.truth.set_integer("oversampling", 8);
  set_truth(plan, "scale_factor_error", -60.0, "ppm");
  set_truth(plan, "misalignment_O", 50.0, "arcsec");
  set_truth(plan, "misalignment_S", -40.0, "arcsec");
  set_truth(plan, "angle_random_walk", 0.005, "deg/sqrt(h)");
  linear::add_table_motions(plan, 40.0, 12.0, 0.7);
  const double lag_error = 0.01 * RandomStream(seed).split("loop").normal(0);
  plan.settings.set_number("natural_frequency", 55.0 * (1.0 + lag_error), Unit::parse("Hz"));
  plan.settings.set_number("damping_ratio", 0.5, Unit());
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  lose_samples(trial.evidence.recordings.front(), seed, 50);
  for (const auto& [name, value] : coefficients) trial.truth.emplace_back(name, plan.truth.number(name));
  return trial;
}

}  // namespace

extern const Method sdof_gyro_dynamic = linear_method<sdof_gyro_support::roles, problem_of, finished>({
    .name = "sdof_gyro_dynamic",
    .summary = "coefficients of a single-degree-of-freedom gyro over angular motion, from rates and oscillations",
    .source = "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 35-41",
    .options = options,
    .trial = trial,
    .takes_prior = true,
    .second_trial = second_trial,
});

}  // namespace tumble::sdof_gyro_dynamic
