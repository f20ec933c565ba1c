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
using Input::w_x, Input::w_y, Input::w_z, Input::a_x, Input::a_y, Input::a_z, Input::f_x, Input::f_y, Input::f_z;

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
  return {{"D_F", "D_F", "deg/h", "drift independent of specific force", 1.0},
          {"D_I", "D_I", first, "drift per f_I (mass offset along S)", f_x},
          {"D_O", "D_O", first, "drift per f_O (no known mechanism)", f_y},
          {"D_S", "D_S", first, "drift per f_S (mass offset along I)", f_z},
          {"D_IO", "D_IO", second, "drift per f_I f_O", f_x * f_y},
          {"D_OS", "D_OS", second, "drift per f_O f_S", f_y * f_z},
          {"D_IS", "D_IS", second, "drift per f_I f_S (unequal compliance along I and S)", f_x * f_z},
          {"D_II", "D_II", second, "drift per f_I^2", power(f_x, 2)},
          {"D_OO", "D_OO", second, "drift per f_O^2 (no known mechanism; not separable from D_F in a 1 g field)",
           power(f_y, 2)},
          {"D_SS", "D_SS", second, "drift per f_S^2", power(f_z, 2)}};
}

/// docs/equations (4.11); w in the axes I, O, S. The last term is of the order of K_III: angular acceleration about O
/// tilts the gimbal by -I_O w_O'/k, and the momentum with it.
std::vector<Term> motion_terms() {
  const std::string acceleration = "s", product = "s/rad", cube = "s^2/rad^2";
  return {{"K_I", "K_I", acceleration, "per angular acceleration about I", a_x},
          {"K_O", "K_O", acceleration, "per angular acceleration about O", a_y},
          {"K_S", "K_S", acceleration, "per angular acceleration about S", a_z},
          {"K_IO", "K_IO", product, "per w_I w_O", w_x * w_y},
          {"K_OS", "K_OS", product, "per w_O w_S", w_y * w_z},
          {"K_IS", "K_IS", product, "per w_I w_S (unequal inertias, and the tilt of the gimbal)", w_x * w_z},
          {"K_II", "K_II", product, "per w_I^2 (and second-order non-linearity of the torquer)", power(w_x, 2)},
          {"K_SS", "K_SS", product, "per w_S^2", power(w_z, 2)},
          {"K_III", "K_III", cube, "per w_I^3 (and third-order non-linearity of the torquer)", power(w_x, 3)},
          {"K_ISS", "K_ISS", cube, "per w_I w_S^2", w_x * w_z * w_z},
          {"tilt_coupling", "K_O'S", "s^2/rad", "per angular acceleration about O times w_S (not in the lecture)",
           a_y * w_z}};
}

/// scale factor and axis of the mounted instrument
std::vector<Term> input_terms() {
  return {{"scale_factor_error", "dS", "ppm", "relative error of the nominal scale factor", w_x},
          {"scale_factor_asymmetry", "dS_a", "ppm", "scale factor for positive minus that for negative rates",
           0.5 * magnitude(w_x)},
          {"misalignment_O", "m_O", "arcsec", "angle of the input axis from I toward O", w_y},
          {"misalignment_S", "m_S", "arcsec", "angle of the input axis from I toward S", w_z}};
}

std::vector<Output> outputs(const Settings&) {
  Output output{"gyro", QuantityKind::angular_rate, "deg/h", w_x, {}, ""};
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
