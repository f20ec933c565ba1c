#include "tumble/methods/method.hpp"
#include "tumble/reduce/accelerometer/output.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/linear/table_trial.hpp"
#include "tumble/reduce/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer_dynamic {
namespace {

using linear::Problem;

std::vector<Role> roles() { return {accelerometer::role()}; }

std::vector<Option> options() {
  using Type = Option::Type;
  auto options = linear::options("2 s", "1 s");
  options.push_back(linear::bias_instability_option("ug"));
  for (auto& option : linear::loop_options()) options.push_back(std::move(option));
  options.push_back(accelerometer::scale_factor_option("of a current, voltage or pulses: \"1.25 mA/g\""));
  options.push_back({"static_terms",
                     Type::word,
                     "1",
                     "first",
                     {"none", "constant", "first", "second"},
                     "static model fitted with the rest: none, the bias, with scale factor and misalignments, with the "
                     "second order too"});
  options.push_back({"tilt",
                     Type::quantity,
                     "1/g",
                     "0 1/g",
                     {},
                     "m L/(K + C): tilt of the pendulum per specific force, known from the loop stiffness"});
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

/// y - f_I on the regressors of (4.18), with the static terms that f shows besides.
Problem problem_of(const Settings& settings, const Channel* channel) {
  Problem problem;
  problem.role = "accelerometer";
  problem.input = [](const Felt& felt) { return felt.specific_force.x; };
  if (channel) problem.scale = accelerometer::scale_of(settings, *channel);
  linear::set_options(settings, problem);
  linear::set_loop(settings, "pendulous_accelerometer", problem);
  std::vector<std::string> names{"C_I", "C_O", "C_P", "C_IP", "C_OP", "C_IO", "C_II", "C_PP", "C_III", "C_IPP"};
  for (auto& name : static_terms(settings.word("static_terms"))) names.push_back(std::move(name));
  problem.columns = linear::terms_of("pendulous_accelerometer", constants_with_tilt(settings.number("tilt")), names);
  problem.condition_limit = 1e3;
  problem.leave_out_first = {"second_order_oo", "second_order_pp", "misalignment_p", "misalignment_o"};
  problem.advice = {"distinguish_by_rates_and_oscillations"};
  return problem;
}

Estimate finished(const linear::Solution& solution, const Settings& settings) {
  Estimate estimate = linear::answer_of(solution, "accelerometer_dynamic", "g", {"i", "p", "o"}, "deg/s");
  const auto note = [&](const char* text) { estimate.findings.push_back({Finding::Severity::info, text, ""}); };
  if (find_parameter(estimate, "C_O") || find_parameter(estimate, "C_IP"))
    note(
        "C_O and C_IP hold the lever arm along P: L' = L + r_P, where r_P is the distance of the hinge from the point "
        "that the rig's lever_x, lever_y and lever_z give");
  if (settings.number("tilt") == 0.0)
    note("tilt is zero: the term m L/(K + C) f_P a_c, often larger than C_III and C_IPP, is not in the model");
  return estimate;
}

Estimate identify(const Evidence& evidence, const Progress&) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  const auto& settings = evidence.plan.settings;
  const auto& channel = require_channel(evidence, evidence.recordings.front(), "accelerometer");
  return finished(linear::identify(evidence, problem_of(settings, &channel)), settings);
}

Estimate predict(const Plan& plan) {
  return finished(linear::predict(plan, problem_of(plan.settings, nullptr), linear::truth_of(plan, "accelerometer")),
                  plan.settings);
}

struct Value {
  const char* name;
  double value;
  const char* unit;
};

constexpr Value coefficients[] = {{"C_I", -12, "ug/(rad/s^2)"},   {"C_O", 900, "ug/(rad/s^2)"},
                                  {"C_P", 8, "ug/(rad/s^2)"},     {"C_IP", 850, "ug/(rad/s)^2"},
                                  {"C_OP", -12, "ug/(rad/s)^2"},  {"C_IO", 8, "ug/(rad/s)^2"},
                                  {"C_II", 15, "ug/(rad/s)^2"},   {"C_PP", -15, "ug/(rad/s)^2"},
                                  {"C_III", -4, "ppm/(rad/s)^2"}, {"C_IPP", 4, "ppm/(rad/s)^2"}};

/// Positions, rates about one and two axes, and oscillations on a two-axis table.
Trial trial(std::uint64_t seed) {
  Plan plan = trial_plan("accelerometer_dynamic", options(), "pendulous_accelerometer", "two_axis_table", 20.0);
  const auto set = [&](const char* name, double value, const char* unit) { set_truth(plan, name, value, unit); };
  for (const auto& one : coefficients) set(one.name, one.value, one.unit);
  set("bias", 2.5, "mg");
  set("scale_factor_error", 120, "ppm");
  set("misalignment_o", 40, "arcsec");
  set("misalignment_p", -25, "arcsec");
  set("angle_random_walk", 0.003, "(m/s)/sqrt(h)");
  set("bias_instability", 3, "ug");
  linear::add_table_motions(plan);
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  for (const auto& one : coefficients) trial.truth.emplace_back(one.name, plan.truth.number(one.name));
  return trial;
}

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan) {
  const Settings settings = settings_of(estimate, options());
  return accelerometer::compensated(estimate, recording, plan, settings, problem_of(settings, nullptr).columns);
}

}  // namespace

extern const Method accelerometer_dynamic{
    .name = "accelerometer_dynamic",
    .summary = "coefficients of a pendulous accelerometer over angular motion, from rates and oscillations",
    .source = "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 42-46",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .trial = trial,
    .compensate = compensate,
    .predict = predict};

}  // namespace tumble::accelerometer_dynamic
