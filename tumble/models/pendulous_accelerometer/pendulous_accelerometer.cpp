// Axes of what is felt: x = i (input), y = p (pendulum), z = o (output), i x p = o as in GJB 2504 and IEEE Std 1293.
// The dynamic terms keep the letters and signs of the lecture, whose axes are I = i, P = p, O = -o (I x O = P).

#include <cmath>

#include "tumble/core/attempt.hpp"
#include "tumble/models/electronics/stages.hpp"
#include "tumble/models/given/given.hpp"
#include "tumble/models/model.hpp"
#include "tumble/models/pendulous_accelerometer/physics.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::pendulous_accelerometer {
namespace {

using namespace given;
using Input::w_x, Input::w_y, Input::w_z, Input::a_x, Input::a_y, Input::a_z, Input::f_x, Input::f_y, Input::f_z;

std::vector<Option> constants() {
  std::vector<Option> options{
      word("output", {"specific_force", "current", "voltage", "count"})
          .otherwise("specific_force")
          .says("recorded quantity: the indicated specific force, the torquer current, its voltage, or pulses of a "
                "current-to-frequency converter"),
      quantity("current_scale_factor", "mA/g").says("K_1 of the current; absent: from the physics"),
      quantity("voltage_scale_factor", "V/g").says("K_1 of the voltage"),
      quantity("pulse_scale_factor", "pulse/s/g").says("K_1 of the pulses"),
      quantity("reference_temperature", "degC")
          .otherwise("20 degC")
          .says("temperature at which the temperature terms are zero")};
  for (auto& option : electronics::loop_options()) options.push_back(std::move(option));
  for (auto& option : electronics::limit_options("g")) options.push_back(std::move(option));
  for (auto& option : stiffness_constants()) options.push_back(std::move(option));
  return options;
}

/// K_0 and K_1 over temperature, per K and K^2 from T_ref.
std::vector<Term> temperature_terms(double reference) {
  const auto scaled = [reference](int n, bool by_force) {
    const Regressor warmed = power(from(Input::temperature, reference), n);
    return by_force ? warmed * f_x : warmed;
  };
  return {
      {"bias_temperature_coefficient", "K_0T", "ug/K", "bias per kelvin from reference_temperature", scaled(1, false)},
      {"bias_temperature_square", "K_0TT", "ug/K^2", "bias per kelvin squared", scaled(2, false)},
      {"scale_factor_temperature_coefficient", "K_1T", "ppm/K", "scale factor error per kelvin", scaled(1, true)},
      {"scale_factor_temperature_square", "K_1TT", "ppm/K^2", "scale factor error per kelvin squared",
       scaled(2, true)}};
}

/// docs/equations (4.19), then the terms that GJB 2504 does not have; a in the axes i, p, o
std::vector<Term> static_terms() {
  const std::string second = "ug/g^2", third = "ug/g^3";
  return {{"bias", "K_0", "mg", "bias", 1.0},
          {"scale_factor_error", "dK_1", "ppm", "relative error of the nominal scale factor", f_x},
          {"second_order_coefficient", "K_2", second, "per a_i^2", power(f_x, 2)},
          {"third_order_coefficient", "K_3", third, "per a_i^3", power(f_x, 3)},
          {"cross_coupling_ip", "K_ip", second, "per a_i a_p", f_x * f_y},
          {"cross_coupling_io", "K_io", second, "per a_i a_o", f_x * f_z},
          {"misalignment_o", "delta_o", "arcsec", "turn of the input axis about o, per a_p", f_y},
          {"misalignment_p", "delta_p", "arcsec", "turn of the input axis about p, per -a_o", -f_z},
          // beyond GJB 2504
          {"cross_coupling_po", "K_po", second, "per a_p a_o", f_y * f_z},
          {"second_order_pp", "K_pp", second, "per a_p^2 (not observable in a 1 g tumble)", power(f_y, 2)},
          {"second_order_oo", "K_oo", second, "per a_o^2 (not observable in a 1 g tumble)", power(f_z, 2)},
          {"odd_quadratic_coefficient", "K_oq", second, "per a_i |a_i|", f_x * magnitude(f_x)}};
}

/// docs/equations (4.18). The pendulum tilts with f_I + a_c, so K_IP f_I f_P comes with tilt f_P a_c: each regressor of
/// a_c is taken 1 + tilt f_P times, tilt = m L/(K + C).
std::vector<Term> motion_terms(double tilt) {
  struct Row {
    const char* name;
    const char* description;
    bool acceleration;
    Regressor regressor;
  };
  const Regressor w_I = w_x, w_O = -w_z, w_P = w_y;
  const Row rows[] = {{"C_I", "per angular acceleration about I", true, a_x},
                      {"C_O", "per angular acceleration about O = -o", true, -a_z},
                      {"C_P", "per angular acceleration about P", true, a_y},
                      {"C_IP", "per w_I w_P (unequal inertias)", false, w_I * w_P},
                      {"C_OP", "per w_O w_P, O = -o", false, w_O * w_P},
                      {"C_IO", "per w_I w_O, O = -o", false, w_I * w_O},
                      {"C_II", "per w_I^2", false, w_I * w_I},
                      {"C_PP", "per w_P^2", false, w_P * w_P}};
  std::vector<Term> terms;
  for (const auto& row : rows)
    terms.push_back({row.name, row.name, row.acceleration ? "ug/(rad/s^2)" : "ug/(rad/s)^2", row.description,
                     (1.0 + Regressor(tilt) * f_y) * row.regressor});
  terms.push_back({"C_III", "C_III", "ppm/(rad/s)^2", "per f_I w_I^2 (tilt of the pendulum)", f_x * w_x * w_x});
  terms.push_back({"C_IPP", "C_IPP", "ppm/(rad/s)^2", "per f_I w_P^2 (tilt of the pendulum)", f_x * w_y * w_y});
  return terms;
}

std::vector<Output> outputs(const Settings& constants) {
  Output output{"accelerometer", QuantityKind::specific_force, "g", f_x, static_terms(), ""};
  for (auto& term : temperature_terms(constants.number("reference_temperature")))
    output.terms.push_back(std::move(term));
  for (auto& term : motion_terms(tilt_per_specific_force(constants))) output.terms.push_back(std::move(term));
  return {output};
}

/// G = w_n^2/(s^2 + 2 zeta w_n s + w_n^2) from the constants, else from J_O, D and K + C
Response servo_loop(const Settings& truth, double step) {
  if (truth.has("natural_frequency")) return electronics::loop(truth, step);
  if (!truth.has("servo_stiffness") || truth.flag("integrator")) return nullptr;
  const double stiffness = truth.number("servo_stiffness") + truth.number("hinge_stiffness");
  return electronics::balanced(number_or(truth, "pendulum_inertia_O", 0.0), number_or(truth, "damping", 0.0), stiffness,
                               step);
}

/// K_1 of the recorded word [SI], not zero
double scale_factor(const Settings& truth, const std::string& word) {
  const std::string name = (word == "count" ? "pulse" : word) + "_scale_factor";
  double scale = number_or(truth, name, 0.0);
  if (!truth.has(name) && word == "current") scale = current_scale_factor(truth);
  if (scale == 0.0)
    refuse({say("output = \"{}\" needs {}, not zero{}", word, Name{name},
                word == "current" ? ", or pendulosity and torquer_constant" : "")});
  return scale;
}

Recorded record(const Settings& truth, std::size_t, double step, const RandomStream& random) {
  const std::string word = truth.word("output");
  Problems problems;
  std::vector<Response> stages{attempt(problems, [&] { return servo_loop(truth, step); }),
                               attempt(problems, [&] { return electronics::limits(truth); })};
  if (word != "specific_force")
    stages.push_back(attempt(problems, [&] { return electronics::scaled(scale_factor(truth, word)); }));
  if (word == "count") stages.push_back(electronics::pulse_counter(step, random.split("start phase").uniform(0)));
  refuse(std::move(problems));
  const Response response = electronics::in_series(std::move(stages));
  if (word == "specific_force") return {QuantityKind::specific_force, "g", false, response};
  if (word == "count") return {QuantityKind::count, "pulse", true, response};
  return {QuantityKind::other, word == "current" ? "mA" : "V", false, response};
}

}  // namespace

extern const Model pendulous_accelerometer{
    .name = "pendulous_accelerometer",
    .summary =
        "pendulous accelerometer: GJB 2504 static model, angular-motion terms, servo loop, current or I/F pulses",
    .source =
        "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 42-48; Lu Hanjie et al., 2019, "
        "section 2.1",
    .constants = constants,
    .outputs = outputs,
    .physics = physics,
    .coefficients = coefficients,
    .record = record};

}  // namespace tumble::pendulous_accelerometer
