#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/exchange/calibration.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble {
namespace {

using Triad = TriadCalibration ImuCalibration::*;
constexpr Triad force_triad = &ImuCalibration::accelerometers, rate_triad = &ImuCalibration::gyros;

template <Triad triad>
bool has_bias(const ImuCalibration& c) {
  return norm((c.*triad).bias) > 0.0;
}

template <Triad triad>
void remove_bias(ImuCalibration& c) {
  (c.*triad).bias = {};
}

template <Triad triad>
bool has_scale(const ImuCalibration& c) {
  return norm(diagonal_of((c.*triad).response) - Vector3{1.0, 1.0, 1.0}) > 0.0;
}

template <Triad triad>
void remove_scale(ImuCalibration& c) {
  for (std::size_t i = 0; i < 3; ++i) (c.*triad).response(i, i) = 1.0;
}

template <Triad triad>
bool has_misalignment(const ImuCalibration& c) {
  const Matrix3 off = (c.*triad).response - diagonal3(diagonal_of((c.*triad).response));
  return norm(off.x) + norm(off.y) + norm(off.z) > 0.0;
}

template <Triad triad>
void remove_misalignment(ImuCalibration& c) {
  (c.*triad).response = diagonal3(diagonal_of((c.*triad).response));
}

template <Triad triad>
bool has_curve(const ImuCalibration& c) {
  return std::ranges::any_of((c.*triad).curve, [](const OwnCurve& curve) { return !curve.is_zero(); });
}

template <Triad triad>
void remove_curve(ImuCalibration& c) {
  (c.*triad).curve = {};
  (c.*triad).measured = {};
}

template <Triad triad>
bool has_thermal_bias(const ImuCalibration& c) {
  return std::ranges::any_of((c.*triad).thermal,
                             [](const AxisThermal& t) { return !t.output.empty() || !t.bias.empty(); });
}

template <Triad triad>
void remove_thermal_bias(ImuCalibration& c) {
  for (auto& axis : (c.*triad).thermal) axis.output.clear(), axis.bias.clear();
}

template <Triad triad>
bool has_thermal_scale(const ImuCalibration& c) {
  return std::ranges::any_of((c.*triad).thermal, [](const AxisThermal& t) { return !t.scale.empty(); });
}

template <Triad triad>
void remove_thermal_scale(ImuCalibration& c) {
  for (auto& axis : (c.*triad).thermal) axis.scale.clear();
}

bool has_by_force(const ImuCalibration& c) {
  return norm(c.gyros.by_force.x) + norm(c.gyros.by_force.y) + norm(c.gyros.by_force.z) > 0.0;
}

bool has_lever(const ImuCalibration& c) {
  return norm(c.accelerometers.lever.x) + norm(c.accelerometers.lever.y) + norm(c.accelerometers.lever.z) > 0.0;
}

bool has_transient(const ImuCalibration& c) { return norm(c.gyros.transient) > 0.0; }

template <Triad triad>
void add(std::vector<CalibrationTerm>& terms, std::array<const char*, 6> names) {
  constexpr bool gyro = triad == rate_triad;
  terms.push_back({names[0], "output at zero input", gyro, has_bias<triad>, remove_bias<triad>});
  terms.push_back({names[1], "scale factors", gyro, has_scale<triad>, remove_scale<triad>});
  terms.push_back(
      {names[2], "misalignments and non-orthogonality", gyro, has_misalignment<triad>, remove_misalignment<triad>});
  terms.push_back({names[3], "second and higher order, asymmetry", gyro, has_curve<triad>, remove_curve<triad>});
  terms.push_back({names[4], "bias over temperature", gyro, has_thermal_bias<triad>, remove_thermal_bias<triad>});
  terms.push_back(
      {names[5], "scale factors over temperature", gyro, has_thermal_scale<triad>, remove_thermal_scale<triad>});
}

std::vector<CalibrationTerm> all_terms() {
  std::vector<CalibrationTerm> terms;
  add<force_triad>(terms,
                   {"accelerometer_bias", "accelerometer_scale_factor", "accelerometer_misalignment",
                    "accelerometer_nonlinearity", "accelerometer_thermal_bias", "accelerometer_thermal_scale_factor"});
  terms.push_back({"accelerometer_lever", "positions of the accelerometers", false, has_lever,
                   [](ImuCalibration& c) { c.accelerometers.lever = {}; }});
  add<rate_triad>(terms, {"gyro_bias", "gyro_scale_factor", "gyro_misalignment", "gyro_nonlinearity",
                          "gyro_thermal_bias", "gyro_thermal_scale_factor"});
  terms.push_back({"gyro_acceleration_sensitivity", "drift with specific force", true, has_by_force,
                   [](ImuCalibration& c) { c.gyros.by_force = {}; }});
  terms.push_back({"gyro_thermal_transient", "drift with temperature gradient and rate, and after switching on", true,
                   has_transient, [](ImuCalibration& c) { c.gyros.transient = {}; }});
  return terms;
}

}  // namespace

const std::vector<CalibrationTerm>& calibration_terms() {
  static const std::vector<CalibrationTerm> terms = all_terms();
  return terms;
}

const CalibrationTerm& find_calibration_term(std::string_view name) {
  std::vector<std::string> known;
  for (const auto& term : calibration_terms()) {
    if (term.name == name) return term;
    known.emplace_back(term.name);
  }
  throw Error(Error::Kind::bad_input, say("there is no term '{}'{} (known: {})", std::string(name),
                                          did_you_mean(std::string(name), known), fmt::join(known, ", ")));
}

}  // namespace tumble
