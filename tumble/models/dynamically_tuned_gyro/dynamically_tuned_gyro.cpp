// Axes of what is felt: x = X, y = Y (the two input axes), z = Z (spin), right-handed.

#include "tumble/models/electronics/stages.hpp"
#include "tumble/models/given/given.hpp"
#include "tumble/models/model.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::dynamically_tuned_gyro {
namespace {

using namespace given;
using Input::w_x, Input::w_y, Input::w_z, Input::f_x, Input::f_y, Input::f_z;

std::vector<Option> constants() {
  std::vector<Option> options{quantity("time_constant", "s")
                                  .above(0)
                                  .says("time constant of a first-order capture loop, instead of natural_frequency")};
  for (auto& option : electronics::loop_options()) options.push_back(std::move(option));
  for (auto& option : electronics::limit_options("deg/s")) options.push_back(std::move(option));
  return options;
}

/// docs/equations (1.4) with its cubic terms; `axis` X or Y in symbols, `prefix` before the names
std::vector<Term> drift_terms(const std::string& axis, const std::string& prefix) {
  struct Row {
    const char* letters;  ///< one for each factor
    const char* unit;
    const char* description;
    Regressor regressor;
  };
  const Row rows[] = {{"x", "deg/h/g", "per f_X (mass unbalance on the X axis, quadrature on the Y axis)", f_x},
                      {"y", "deg/h/g", "per f_Y (quadrature on the X axis, mass unbalance on the Y axis)", f_y},
                      {"z", "deg/h/g", "per f_Z", f_z},
                      {"xz", "deg/h/g^2", "per f_X f_Z (anisoelasticity)", f_x * f_z},
                      {"yz", "deg/h/g^2", "per f_Y f_Z (anisoelasticity)", f_y * f_z},
                      {"xx", "deg/h/g^2", "per f_X^2", power(f_x, 2)},
                      {"yy", "deg/h/g^2", "per f_Y^2", power(f_y, 2)},
                      {"xy", "deg/h/g^2", "per f_X f_Y", f_x * f_y},
                      {"xxx", "deg/h/g^3", "per f_X^3", power(f_x, 3)},
                      {"xyy", "deg/h/g^3", "per f_X f_Y^2", f_x * f_y * f_y},
                      {"yyy", "deg/h/g^3", "per f_Y^3", power(f_y, 3)},
                      {"yxx", "deg/h/g^3", "per f_Y f_X^2", f_y * f_x * f_x}};
  const std::string symbol = "D(" + axis + ")_", what = "drift of the " + axis + " output ";
  std::vector<Term> terms{{prefix + "D_F", symbol + "F", "deg/h", what + "independent of specific force", 1.0}};
  for (const auto& row : rows)
    terms.push_back(
        {prefix + "D_" + row.letters, symbol + row.letters, row.unit, what + row.description, row.regressor});
  return terms;
}

/// scale factor and misalignments of docs/equations (1.5); `other` is the second input axis
void append_input_terms(std::vector<Term>& terms, const std::string& axis, const std::string& prefix, char other,
                        Input along, Input across) {
  terms.push_back({prefix + "scale_factor_error", "dS(" + axis + ")", "ppm",
                   "relative error of the nominal scale factor of the " + axis + " output", along});
  const auto upper = static_cast<char>(other - 'a' + 'A');
  terms.push_back({prefix + "gamma_" + other, "gamma(" + axis + ")_" + upper, "arcsec",
                   "angle of the " + axis + " input axis toward " + upper, across});
  terms.push_back(
      {prefix + "gamma_z", "gamma(" + axis + ")_Z", "arcsec", "angle of the " + axis + " input axis toward Z", w_z});
}

std::vector<Output> outputs(const Settings&) {
  Output first{"gyro", QuantityKind::angular_rate, "deg/h", w_x, drift_terms("X", ""), ""};
  append_input_terms(first.terms, "X", "", 'y', w_x, w_y);
  Output second{"gyro_y", QuantityKind::angular_rate, "deg/h", w_y, drift_terms("Y", "y_"), ""};
  append_input_terms(second.terms, "Y", "y_", 'x', w_y, w_x);
  return {first, second};
}

std::vector<Option> physics() {
  return {quantity("angular_momentum", "kg*m^2/s").above(0).says("H of the rotor, along Z"),
          quantity("mass", "kg").above(0).says("m of the rotor"),
          quantity("mass_offset_Z", "nm").says("l_Z: centre of mass from the support point, along the spin axis"),
          quantity("quadrature_torque", "N*m/g").says("q: torque on the rotor in phase with radial specific force"),
          quantity("axial_compliance", "m/N").says("C_a of the flexures along the spin axis"),
          quantity("radial_compliance", "m/N").says("C_r of the flexures across it"),
          quantity("torque_X", "N*m").says("constant torque on the rotor about X"),
          quantity("torque_Y", "N*m").says("constant torque on the rotor about Y")};
}

/// Captured rotor: e_X = M_Y/H, e_Y = -M_X/H with M = (l - m C f) x (-m f) + q (f_X, f_Y, 0)
std::map<std::string, double> coefficients(const Settings& truth) {
  std::vector<std::string> names;
  for (const auto& option : physics()) names.push_back(option.name);
  if (given_of(truth, names).empty()) return {};
  Problems problems;
  require_with(truth, {"mass_offset_Z", "axial_compliance", "radial_compliance"}, {"mass"}, problems);
  names.erase(names.begin());
  require_with(truth, names, {"angular_momentum"}, problems);
  refuse(std::move(problems));
  const auto value = [&](const char* name) { return number_or(truth, name, 0.0); };
  const double H = value("angular_momentum"), m = value("mass");
  const double unbalance = -m * value("mass_offset_Z") / H, quadrature = value("quadrature_torque") / H;
  const double anisoelastic = m * m * (value("axial_compliance") - value("radial_compliance")) / H;
  return {{"D_F", value("torque_Y") / H},
          {"y_D_F", -value("torque_X") / H},
          {"D_x", unbalance},
          {"y_D_y", unbalance},
          {"D_y", quadrature},
          {"y_D_x", -quadrature},
          {"D_xz", anisoelastic},
          {"y_D_yz", anisoelastic}};
}

Recorded record(const Settings& truth, std::size_t, double step, const RandomStream&) {
  return {QuantityKind::angular_rate, "deg/h", false,
          electronics::in_series({electronics::loop(truth, step), electronics::limits(truth)})};
}

}  // namespace

extern const Model dynamically_tuned_gyro{
    .name = "dynamically_tuned_gyro",
    .summary = "dynamically tuned gyro: drift of both axes over specific force to third order, capture loop",
    .source = "CN102636185A, 2012 (the test); drift model with the symbols of IEEE Std 813",
    .constants = constants,
    .outputs = outputs,
    .physics = physics,
    .coefficients = coefficients,
    .record = record};

}  // namespace tumble::dynamically_tuned_gyro
