#include "tumble/models/pendulous_accelerometer/physics.hpp"

#include "tumble/models/given/given.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::pendulous_accelerometer {
namespace {

using namespace given;

void refuse_incomplete(const Settings& truth) {
  Problems problems;
  require_with(truth,
               {"mass_offset_I", "compliance_II", "compliance_PP", "compliance_IP", "compliance_IO", "compliance_PO"},
               {"mass", "pendulosity"}, problems);
  require_with(
      truth,
      {"disturbance_torque", "pendulum_inertia_O", "pendulum_product_IO", "pendulum_product_OP", "pendulum_product_IP"},
      {"pendulosity"}, problems);
  require_with(truth, {"pendulum_inertia_I"}, {"pendulum_inertia_P", "pendulosity"}, problems);
  require_with(truth, {"pendulum_inertia_P"}, {"pendulum_inertia_I", "pendulosity"}, problems);
  refuse(std::move(problems));
}

/// K + C [N m/rad]; 0: the pendulum does not tilt
double total_stiffness(const Settings& constants) {
  if (constants.flag("integrator") || !constants.has("servo_stiffness")) return 0.0;
  return constants.number("servo_stiffness") + constants.number("hinge_stiffness");
}

/// docs/equations (4.17) over K_I = m L/K_T: every coefficient carries the same K/(K + C), which cancels
void static_coefficients(const Settings& truth, double moment, std::map<std::string, double>& of) {
  const auto value = [&](const char* name) { return number_or(truth, name, 0.0); };
  const double m = value("mass"), tilt = tilt_per_specific_force(truth);
  const double lean = m * value("mass_offset_I") / moment;  // l_I/L
  const double elastic = m * m / moment;
  const double second = -elastic * value("compliance_IP") + tilt * lean;  // K_II/K_I
  of["bias"] = value("disturbance_torque") / moment;
  of["misalignment_o"] = -lean;
  of["second_order_coefficient"] = second;
  of["second_order_pp"] = -second;
  of["cross_coupling_ip"] = elastic * (value("compliance_II") - value("compliance_PP")) + tilt;
  of["cross_coupling_io"] = elastic * value("compliance_PO");   // -K_IO/K_I
  of["cross_coupling_po"] = -elastic * value("compliance_IO");  // -K_OP/K_I
}

/// docs/equations (4.18), J about the hinge
void dynamic_coefficients(const Settings& truth, double moment, std::map<std::string, double>& of) {
  const auto per_moment = [&](const char* name) { return number_or(truth, name, 0.0) / moment; };
  const double difference = per_moment("pendulum_inertia_I") - per_moment("pendulum_inertia_P");
  const double tilt = tilt_per_specific_force(truth);
  of["C_I"] = -per_moment("pendulum_product_IO");
  of["C_O"] = per_moment("pendulum_inertia_O");
  of["C_P"] = -per_moment("pendulum_product_OP");
  of["C_IP"] = difference;
  of["C_OP"] = -per_moment("pendulum_product_IO");
  of["C_IO"] = per_moment("pendulum_product_OP");
  of["C_II"] = per_moment("pendulum_product_IP");
  of["C_PP"] = -per_moment("pendulum_product_IP");
  of["C_III"] = -difference * tilt;  // (J_I - J_P)/(K + C)
  of["C_IPP"] = difference * tilt;
}

}  // namespace

std::vector<Option> stiffness_constants() {
  return {
      physical("pendulosity", "kg*m", "m L: mass of the pendulum times its distance from the hinge").above(0),
      physical("servo_stiffness", "N*m/rad", "K = K_s K_a K_T of the servo loop; absent: the tilt is zero").above(0),
      physical("hinge_stiffness", "N*m/rad", "C of the flexure").at_least(0).otherwise("0 N*m/rad"),
      flag("integrator")
          .says("the loop has an integrator: no steady tilt, 1/(K + C) = 0 in docs/equations (4.17)-(4.18)")};
}

std::vector<Option> physics() {
  return {physical("mass", "kg", "m of the pendulum").above(0),
          physical("mass_offset_I", "um", "l_I: centre of mass from the P axis, along I"),
          physical("compliance_II", "m/N", "C_II: displacement of the mass along I per force along I"),
          physical("compliance_PP", "m/N", "C_PP: along P per force along P"),
          physical("compliance_IP", "m/N", "C_IP = C_PI"),
          physical("compliance_IO", "m/N", "C_IO = C_OI, O = -o"),
          physical("compliance_PO", "m/N", "C_PO = C_OP, O = -o"),
          physical("disturbance_torque", "N*m", "M_d0, positive where it acts like positive specific force"),
          physical("pendulum_inertia_I", "kg*m^2", "J_I of the pendulum about the axis I through the hinge").above(0),
          physical("pendulum_inertia_O", "kg*m^2", "J_O about the hinge").above(0),
          physical("pendulum_inertia_P", "kg*m^2", "J_P about the axis P through the hinge").above(0),
          physical("pendulum_product_IO", "kg*m^2", "J_IO: product of inertia, integral of I O dm, O = -o"),
          physical("pendulum_product_OP", "kg*m^2", "J_OP: integral of O P dm, O = -o"),
          physical("pendulum_product_IP", "kg*m^2", "J_IP: integral of I P dm"),
          physical("damping", "N*m*s/rad", "D about the hinge").above(0),
          physical("torquer_constant", "N*m/A", "K_T of the torquer").above(0)};
}

double tilt_per_specific_force(const Settings& constants) {
  Problems problems;
  require_with(constants, {"servo_stiffness"}, {"pendulosity"}, problems);
  refuse(std::move(problems));
  const double stiffness = total_stiffness(constants);
  return stiffness > 0.0 ? constants.number("pendulosity") / stiffness : 0.0;
}

double current_scale_factor(const Settings& truth) {
  if (!truth.has("pendulosity") || !truth.has("torquer_constant")) return 0.0;
  const double stiffness = total_stiffness(truth);
  const double gain = stiffness > 0.0 ? truth.number("servo_stiffness") / stiffness : 1.0;
  return gain * truth.number("pendulosity") / truth.number("torquer_constant");
}

std::map<std::string, double> coefficients(const Settings& truth) {
  std::vector<std::string> names{"pendulosity", "servo_stiffness"};
  for (const auto& option : physics()) names.push_back(option.name);
  std::map<std::string, double> of;
  if (given_of(truth, names).empty()) return of;
  refuse_incomplete(truth);
  if (!truth.has("pendulosity")) return of;
  const double moment = truth.number("pendulosity");
  static_coefficients(truth, moment, of);
  dynamic_coefficients(truth, moment, of);
  return of;
}

}  // namespace tumble::pendulous_accelerometer
