#include "tumble/methods/linear_method.hpp"
#include "tumble/reduce/accelerometer/output.hpp"

namespace tumble::accelerometer_dynamic {
namespace {

std::vector<Option> options() {
  auto options = linear::options("2 s", "1 s");
  options.push_back(linear::bias_instability_option("ug"));
  for (auto& option : linear::loop_options()) options.push_back(std::move(option));
  options.push_back(accelerometer::scale_factor_option("of a current, voltage or pulses: \"1.25 mA/g\""));
  options.push_back(word("static_terms", {"none", "constant", "first", "second"})
                        .otherwise("first")
                        .says("static model that is fitted too: none, the bias, also scale factor and misalignments, "
                              "also the second order"));
  options.push_back(quantity("tilt", "1/g")
                        .at_least(0)
                        .otherwise("0 1/g")
                        .says("m L/(K + C): tilt of the pendulum per specific force, as the stiffness of the loop "
                              "gives it"));
  return options;
}

std::vector<std::string> static_terms(const std::string& which) {
  std::vector<std::string> names;
  if (which != "none") names.emplace_back("bias");
  if (which == "first" || which == "second")
    for (const char* name : {"scale_factor_error", "misalignment_o", "misalignment_p"}) names.emplace_back(name);
  if (which == "second")
    for (const char* name : {"second_order_coefficient", "cross_coupling_ip", "cross_coupling_io", "cross_coupling_po",
                             "second_order_pp", "second_order_oo"})
      names.emplace_back(name);
  return names;
}

/// The constants of the model that give the tilt asked for.
Settings constants_with_tilt(double tilt) {
  Settings constants = defaults(find_model("pendulous_accelerometer").constants());
  if (tilt == 0.0) return constants;
  constants.set_number("pendulosity", tilt, Unit::parse("kg*m"));
  constants.set_number("servo_stiffness", 1.0, Unit::parse("N*m/rad"));
  return constants;
}

/// y - f_I on the regressors of (4.18), with the static terms.
linear::Problem problem_of(const Settings& settings, const Channel* channel) {
  linear::Problem problem;
  problem.role = "accelerometer";
  problem.input = Input::specific_force_x;
  if (channel) problem.scale = accelerometer::scale_of(settings, *channel);
  linear::set_options(settings, problem);
  linear::set_loop(settings, "pendulous_accelerometer", problem);
  std::vector<std::string> names{"C_I", "C_O", "C_P", "C_IP", "C_OP", "C_IO", "C_II", "C_PP", "C_III", "C_IPP"};
  for (auto& name : static_terms(settings.word("static_terms"))) names.push_back(std::move(name));
  problem.columns = linear::terms_of("pendulous_accelerometer", constants_with_tilt(settings.number("tilt")), names);
  problem.condition_limit = linear::weakest_in_motion;
  problem.leave_out_first = {"second_order_oo", "second_order_pp", "misalignment_p", "misalignment_o"};
  problem.advice = {"distinguish_by_rates_and_oscillations"};
  return problem;
}

Estimate finished(const linear::Solution& solution, const Settings& settings) {
  Estimate estimate = linear::answer_of(solution, "g", {"i", "p", "o"}, "deg/s");
  if (find_parameter(estimate, "C_O") || find_parameter(estimate, "C_IP"))
    estimate.findings.push_back({Finding::Severity::info, "lever_arm_in_C_O_and_C_IP", {}});
  if (settings.number("tilt") == 0.0)
    estimate.findings.push_back({Finding::Severity::info, "tilt_of_the_pendulum_is_zero", {}});
  return estimate;
}

}  // namespace

extern const Method accelerometer_dynamic = linear_method<accelerometer::roles, problem_of, finished>({
    .name = "accelerometer_dynamic",
    .summary = "coefficients of a pendulous accelerometer over angular motion, from rates and oscillations",
    .source = "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 42-46",
    .options = options,
    .compensates = true,
    .takes_prior = true,
});

}  // namespace tumble::accelerometer_dynamic
