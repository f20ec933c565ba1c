#include "tumble/models/sdof_gyro/physics.hpp"

#include <fmt/format.h>

#include "tumble/models/given/given.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::sdof_gyro {
namespace {

using namespace given;

const std::vector<std::string> masses{"mass_offset_I", "mass_offset_S", "compliance_II", "compliance_SS",
                                      "compliance_IS", "compliance_IO", "compliance_SO"};
const std::vector<std::string> inertias{"gimbal_inertia_I",  "gimbal_inertia_O",  "gimbal_inertia_S",
                                        "gimbal_product_IO", "gimbal_product_OS", "gimbal_product_IS"};
const std::vector<std::string> gains{"pickoff_gain", "amplifier_gain", "torquer_constant"};

std::vector<std::string> quantities() {
  std::vector<std::string> names;
  for (const auto& option : physics())
    if (option.type == Option::Type::quantity) names.push_back(option.name);
  return names;
}

void refuse_incomplete(const Settings& truth) {
  Problems problems;
  require_with(truth, masses, {"mass"}, problems);
  require_with(truth, {"rotor_inertia"}, {"spin_rate"}, problems);
  require_with(truth, {"spin_rate"}, {"rotor_inertia"}, problems);
  require_with(truth, {"pickoff_gain", "amplifier_gain"}, gains, problems);
  const auto moments = given_of(truth, {"gimbal_inertia_I", "gimbal_inertia_S"});
  if (moments.size() == 1)
    problems.push_back(say("{}: K_IS needs gimbal_inertia_I and gimbal_inertia_S", Name{moments[0]}));
  const bool direct = truth.has("angular_momentum"), derived = truth.has("rotor_inertia");
  if (direct && derived) problems.push_back("give angular_momentum, or rotor_inertia and spin_rate, not both");
  if (!direct && !derived)
    problems.push_back(say("{}: needs angular_momentum, or rotor_inertia and spin_rate, as well",
                           fmt::join(given_of(truth, quantities()), ", ")));
  if (truth.has("loop_stiffness") && truth.has("pickoff_gain"))
    problems.push_back("give loop_stiffness, or pickoff_gain and amplifier_gain, not both");
  refuse(std::move(problems));
}

/// docs/equations (4.4): the mass lags by C m f, the torque is (l - C m f) x (-m f)
void static_coefficients(const Settings& truth, double H, std::map<std::string, double>& of) {
  const auto value = [&](const char* name) { return number_or(truth, name, 0.0); };
  const double m = value("mass");
  of["D_F"] = value("disturbance_torque") / H;
  of["D_I"] = -m * value("mass_offset_S") / H;
  of["D_S"] = m * value("mass_offset_I") / H;
  of["D_IO"] = m * m * value("compliance_SO") / H;
  of["D_OS"] = -m * m * value("compliance_IO") / H;
  of["D_IS"] = m * m * (value("compliance_SS") - value("compliance_II")) / H;
  of["D_II"] = m * m * value("compliance_IS") / H;
  of["D_SS"] = -m * m * value("compliance_IS") / H;
}

/// docs/equations (4.11), K_III and K_ISS exact to second order in 1/k, and what -I_O w_O' adds by way of the tilt
void dynamic_coefficients(const Settings& truth, double H, std::map<std::string, double>& of) {
  const auto value = [&](const char* name) { return number_or(truth, name, 0.0); };
  const double k = loop_stiffness(truth), per_k = k > 0.0 ? 1.0 / k : 0.0;
  const double difference = value("gimbal_inertia_S") - value("gimbal_inertia_I"), tilt = H * per_k;
  of["K_I"] = value("gimbal_product_IO") / H;
  of["K_O"] = -value("gimbal_inertia_O") / H;
  of["K_S"] = value("gimbal_product_OS") / H;
  of["K_IO"] = -value("gimbal_product_OS") / H;
  of["K_OS"] = value("gimbal_product_IO") / H;
  of["K_IS"] = difference / H - tilt;
  of["K_II"] = -value("gimbal_product_IS") / H;
  of["K_SS"] = value("gimbal_product_IS") / H;
  of["K_III"] = difference * per_k - 0.5 * tilt * tilt;
  of["K_ISS"] = -2.0 * difference * per_k + tilt * tilt;
  of["tilt_coupling"] = value("gimbal_inertia_O") * per_k;
}

}  // namespace

std::vector<Option> physics() {
  return {physical("angular_momentum", "kg*m^2/s", "H of the rotor, along S").above(0),
          physical("rotor_inertia", "kg*m^2",
                   "moment of inertia of the rotor about its spin axis; with spin_rate instead of H")
              .above(0),
          physical("spin_rate", "rpm", "spin rate of the rotor").above(0),
          physical("mass", "kg", "m of the float (gimbal and rotor)").above(0),
          physical("mass_offset_I", "nm", "l_I: centre of mass from the output axis, along I"),
          physical("mass_offset_S", "nm", "l_S: centre of mass from the output axis, along S"),
          physical("compliance_II", "m/N", "C_II: displacement along I per force along I"),
          physical("compliance_SS", "m/N", "C_SS: along S per force along S"),
          physical("compliance_IS", "m/N", "C_IS = C_SI"),
          physical("compliance_IO", "m/N", "C_IO = C_OI"),
          physical("compliance_SO", "m/N", "C_SO = C_OS"),
          physical("disturbance_torque", "N*m", "M_d0 about O: flex leads, magnetic reaction"),
          physical("gimbal_inertia_I", "kg*m^2", "I_I: moment of inertia of the float about I").above(0),
          physical("gimbal_inertia_O", "kg*m^2", "I_O: about the output axis").above(0),
          physical("gimbal_inertia_S", "kg*m^2", "I_S: about S").above(0),
          physical("gimbal_product_IO", "kg*m^2", "I_IO: product of inertia, integral of I O dm"),
          physical("gimbal_product_OS", "kg*m^2", "I_OS: integral of O S dm"),
          physical("gimbal_product_IS", "kg*m^2", "I_IS: integral of I S dm"),
          physical("pickoff_gain", "V/rad", "k_u of the loop").above(0),
          physical("amplifier_gain", "A/V", "k_i of the loop").above(0),
          physical("torquer_constant", "N*m/A", "k_m of the torquer").above(0),
          physical("loop_stiffness", "N*m/rad", "k = k_u k_i k_m, instead of the gains; absent: beta is 0").above(0),
          physical("damping", "N*m*s/rad", "D about the output axis").above(0),
          flag("integrator")
              .says("the loop has an integrator: no steady pick-off angle, 1/k = 0 in docs/equations (4.11)")};
}

double angular_momentum(const Settings& truth) {
  if (truth.has("angular_momentum")) return truth.number("angular_momentum");
  return number_or(truth, "rotor_inertia", 0.0) * number_or(truth, "spin_rate", 0.0);
}

double loop_stiffness(const Settings& truth) {
  if (truth.flag("integrator")) return 0.0;
  if (truth.has("loop_stiffness")) return truth.number("loop_stiffness");
  double k = 1.0;
  for (const auto& gain : gains) k *= number_or(truth, gain, 0.0);
  return k;
}

std::map<std::string, double> coefficients(const Settings& truth) {
  std::map<std::string, double> of;
  if (given_of(truth, quantities()).empty()) return of;
  refuse_incomplete(truth);
  const double H = angular_momentum(truth);
  static_coefficients(truth, H, of);
  dynamic_coefficients(truth, H, of);
  return of;
}

}  // namespace tumble::sdof_gyro
