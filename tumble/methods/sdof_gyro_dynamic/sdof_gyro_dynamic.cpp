#include <cmath>

#include "tumble/methods/linear_method.hpp"
#include "tumble/reduce/sdof_gyro_support/gyro.hpp"

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
  problem.condition_limit =
      linear::weakest_in_motion;  // on a table with two axes w_O' w_S is w_I w_S^2, except for the Earth rate
  problem.leave_out_first = {"D_OO", "tilt_coupling", "misalignment_S", "misalignment_O"};
  problem.advice = {"distinguish_by_rates_and_oscillations"};
  return problem;
}

/// K_I = I_IO/H is a product of inertia: of any body at most half the moment about the third axis, which a gimbal has much like
/// that about O. An output that is late by T makes it K_I - T.
void warn_of_a_lag(Estimate& estimate) {
  constexpr double far = 3.0;  // [sd] beyond its uncertainty
  const Parameter *lag = find_parameter(estimate, "K_I"), *inertia = find_parameter(estimate, "K_O");
  if (!lag || !inertia) return;
  const auto sd = [&](const Parameter* parameter) {
    return standard_uncertainty(estimate, static_cast<std::size_t>(parameter - estimate.parameters.data()));
  };
  const double most = std::abs(inertia->value) + far * sd(inertia);
  if (std::abs(lag->value) < most + far * sd(lag)) return;
  estimate.findings.push_back(
      {Finding::Severity::warning, "K_I_is_a_lag", {{"lag", -lag->value, "s"}, {"inertia", most, "s"}}});
}

void add_findings(const Settings& settings, Estimate& estimate) {
  const auto has = [&](const char* name) { return find_parameter(estimate, name) != nullptr; };
  if (has("K_I")) {
    const bool known = settings.has("natural_frequency");
    estimate.findings.push_back({known ? Finding::Severity::info : Finding::Severity::warning,
                                 known ? "K_I_rests_on_the_lag" : "K_I_holds_the_lag",
                                 {}});
    if (known) warn_of_a_lag(estimate);
    for (auto& parameter : estimate.parameters)
      if (!known && parameter.name == "K_I") parameter.description += "; with the lag of the loop, K_I - D/k";
  }
  if (has("K_II") || has("K_III"))
    estimate.findings.push_back({Finding::Severity::info, "torquer_in_K_II_and_K_III", {}});
}

Estimate finished(const linear::Solution& solution, const Settings& settings) {
  Estimate estimate = linear::answer_of(solution, "deg/h", {"I", "O", "S"}, "deg/s");
  add_findings(settings, estimate);
  return estimate;
}

}  // namespace

extern const Method sdof_gyro_dynamic = linear_method<sdof_gyro_support::roles, problem_of, finished>({
    .name = "sdof_gyro_dynamic",
    .summary = "coefficients of a single-degree-of-freedom gyro over angular motion, from rates and oscillations",
    .source = "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 35-41",
    .options = options,
    .compensates = true,
    .takes_prior = true,
});

}  // namespace tumble::sdof_gyro_dynamic
