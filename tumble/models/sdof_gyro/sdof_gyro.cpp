// Axes of what is felt: x = I (input), y = O (output, the gimbal's axis), z = S (spin), I x O = S.

#include <cmath>

#include "tumble/core/attempt.hpp"
#include "tumble/models/electronics/stages.hpp"
#include "tumble/models/given/given.hpp"
#include "tumble/models/model.hpp"
#include "tumble/models/sdof_gyro/physics.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::sdof_gyro {
namespace {

using namespace given;

std::vector<Option> constants() {
  std::vector<Option> options{
      word("output", {"rate", "current"})
          .otherwise("rate")
          .says("recorded quantity: the rate that the loop balances, or the torquer current"),
      quantity("torquer_scale_factor", "deg/h/mA").says("S_g = k_m/H, of the current; absent: from the physics")};
  for (auto& option : electronics::loop_options()) options.push_back(std::move(option));
  for (auto& option : electronics::limit_options("deg/s")) options.push_back(std::move(option));
  return options;
}

/// docs/equations (4.6); f in the axes I, O, S
std::vector<Term> drift_terms() {
  const std::string first = "deg/h/g", second = "deg/h/g^2";
  return {{"D_F", "D_F", "deg/h", "drift independent of specific force", [](const Felt&) { return 1.0; }},
          {"D_I", "D_I", first, "drift per f_I (mass offset along S)",
           [](const Felt& felt) { return felt.specific_force.x; }},
          {"D_O", "D_O", first, "drift per f_O (no known mechanism)",
           [](const Felt& felt) { return felt.specific_force.y; }},
          {"D_S", "D_S", first, "drift per f_S (mass offset along I)",
           [](const Felt& felt) { return felt.specific_force.z; }},
          {"D_IO", "D_IO", second, "drift per f_I f_O",
           [](const Felt& felt) { return felt.specific_force.x * felt.specific_force.y; }},
          {"D_OS", "D_OS", second, "drift per f_O f_S",
           [](const Felt& felt) { return felt.specific_force.y * felt.specific_force.z; }},
          {"D_IS", "D_IS", second, "drift per f_I f_S (unequal compliance along I and S)",
           [](const Felt& felt) { return felt.specific_force.x * felt.specific_force.z; }},
          {"D_II", "D_II", second, "drift per f_I^2",
           [](const Felt& felt) { return felt.specific_force.x * felt.specific_force.x; }},
          {"D_OO", "D_OO", second, "drift per f_O^2 (no known mechanism; not separable from D_F in a 1 g field)",
           [](const Felt& felt) { return felt.specific_force.y * felt.specific_force.y; }},
          {"D_SS", "D_SS", second, "drift per f_S^2",
           [](const Felt& felt) { return felt.specific_force.z * felt.specific_force.z; }}};
}

/// docs/equations (4.11); w in the axes I, O, S. The last term is of the order of K_III: angular acceleration about O
/// tilts the gimbal by -I_O w_O'/k, and the momentum with it.
std::vector<Term> motion_terms() {
  const std::string acceleration = "s", product = "s/rad", cube = "s^2/rad^2";
  return {{"K_I", "K_I", acceleration, "per angular acceleration about I",
           [](const Felt& felt) { return felt.angular_acceleration.x; }},
          {"K_O", "K_O", acceleration, "per angular acceleration about O",
           [](const Felt& felt) { return felt.angular_acceleration.y; }},
          {"K_S", "K_S", acceleration, "per angular acceleration about S",
           [](const Felt& felt) { return felt.angular_acceleration.z; }},
          {"K_IO", "K_IO", product, "per w_I w_O", [](const Felt& felt) { return felt.rate.x * felt.rate.y; }},
          {"K_OS", "K_OS", product, "per w_O w_S", [](const Felt& felt) { return felt.rate.y * felt.rate.z; }},
          {"K_IS", "K_IS", product, "per w_I w_S (unequal inertias, and the tilt of the gimbal)",
           [](const Felt& felt) { return felt.rate.x * felt.rate.z; }},
          {"K_II", "K_II", product, "per w_I^2 (and second-order non-linearity of the torquer)",
           [](const Felt& felt) { return felt.rate.x * felt.rate.x; }},
          {"K_SS", "K_SS", product, "per w_S^2", [](const Felt& felt) { return felt.rate.z * felt.rate.z; }},
          {"K_III", "K_III", cube, "per w_I^3 (and third-order non-linearity of the torquer)",
           [](const Felt& felt) { return felt.rate.x * felt.rate.x * felt.rate.x; }},
          {"K_ISS", "K_ISS", cube, "per w_I w_S^2",
           [](const Felt& felt) { return felt.rate.x * felt.rate.z * felt.rate.z; }},
          {"tilt_coupling", "K_O'S", "s^2/rad", "per angular acceleration about O times w_S (not in the lecture)",
           [](const Felt& felt) { return felt.angular_acceleration.y * felt.rate.z; }}};
}

/// scale factor and axis of the mounted instrument
std::vector<Term> input_terms() {
  return {{"scale_factor_error", "dS", "ppm", "relative error of the nominal scale factor",
           [](const Felt& felt) { return felt.rate.x; }},
          {"scale_factor_asymmetry", "dS_a", "ppm", "scale factor for positive minus that for negative rates",
           [](const Felt& felt) { return 0.5 * std::abs(felt.rate.x); }},
          {"misalignment_O", "m_O", "arcsec", "angle of the input axis from I toward O",
           [](const Felt& felt) { return felt.rate.y; }},
          {"misalignment_S", "m_S", "arcsec", "angle of the input axis from I toward S",
           [](const Felt& felt) { return felt.rate.z; }}};
}

std::vector<Output> outputs(const Settings&) {
  Output output{"gyro", QuantityKind::angular_rate, "deg/h", [](const Felt& felt) { return felt.rate.x; }, {}, ""};
  for (auto part : {drift_terms, motion_terms, input_terms})
    for (auto& term : part()) output.terms.push_back(std::move(term));
  return {output};
}

/// (4.3): from the constants, else from I_O, D and k
Response rebalance_loop(const Settings& truth, double step) {
  if (truth.has("natural_frequency")) return electronics::loop(truth, step);
  return electronics::balanced(number_or(truth, "gimbal_inertia_O", 0.0), number_or(truth, "damping", 0.0),
                               loop_stiffness(truth), step);
}

/// S_g [(rad/s)/A]
double torquer_scale_factor(const Settings& truth) {
  if (truth.has("torquer_scale_factor")) {
    const double scale = truth.number("torquer_scale_factor");
    if (scale == 0.0) refuse({"torquer_scale_factor must not be zero"});
    return scale;
  }
  const double momentum = angular_momentum(truth);
  if (!truth.has("torquer_constant") || !(momentum > 0.0))
    refuse({"output = \"current\" needs torquer_scale_factor, or torquer_constant and the momentum"});
  return truth.number("torquer_constant") / momentum;
}

Recorded record(const Settings& truth, std::size_t, double step, const RandomStream&) {
  Problems problems;
  std::vector<Response> stages{attempt(problems, [&] { return rebalance_loop(truth, step); }),
                               attempt(problems, [&] { return electronics::limits(truth); })};
  const bool current = truth.word("output") == "current";
  if (current)
    stages.push_back(attempt(problems, [&] { return electronics::scaled(1.0 / torquer_scale_factor(truth)); }));
  refuse(std::move(problems));
  const Response response = electronics::in_series(std::move(stages));
  if (current) return {QuantityKind::other, "mA", false, response};
  return {QuantityKind::angular_rate, "deg/h", false, response};
}

}  // namespace

extern const Model sdof_gyro{
    .name = "sdof_gyro",
    .summary = "single-degree-of-freedom rotor gyro: drift over specific force and over angular motion, rebalance loop",
    .source = "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 26-41",
    .constants = constants,
    .outputs = outputs,
    .physics = physics,
    .coefficients = coefficients,
    .record = record};

}  // namespace tumble::sdof_gyro
