#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/autopilot.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/units/error.hpp"

namespace tumble::exports::ardupilot {
namespace {

using namespace writing;

constexpr double zero_celsius = 273.15, reference = 35.0;  ///< [degC] of the vehicle's polynomials

std::vector<Option> options() {
  return {integer("index").between(1, 3).otherwise("1").says("number of the IMU"),
          integer("accelerometer_id").says("INS_ACC_ID; default: not written, the vehicle keeps its own"),
          integer("gyro_id").says("INS_GYR_ID; default: not written, the vehicle keeps its own")};
}

std::string line(const std::string& name, double value) { return fmt::format("{},{}\n", name, real_of_float(value)); }

/// c_1 to c_3 of P(t) = (c_1 + (c_2 + c_3 d) d) d 1e-6, d = t - 35 degC, of which the vehicle subtracts
/// P(T) - P(CALTEMP).
std::array<double, 3> coefficients(const AxisCorrection& axis, double celsius) {
  std::vector<double> powers{0.0};
  powers.insert(powers.end(), axis.temperature.begin(), axis.temperature.end());
  powers.resize(4, 0.0);
  powers = shifted_polynomial(powers, reference - celsius);
  return {1e6 * powers[1], 1e6 * powers[2], 1e6 * powers[3]};
}

/// [K] The temperature of the offsets: the vehicle limits it to TMIN..TMAX, as it does the measured one.
double offset_temperature(const ImuCalibration& c) { return std::clamp(c.reference_temperature, c.coldest, c.hottest); }

/// CALTEMP belongs to the offsets: where the vehicle keeps its own, it keeps their temperature as well.
std::string temperatures(const ImuCalibration& c, const std::array<AxisCorrection, 3>& axes, bool gyro, int index) {
  const double celsius = c.reference_temperature - zero_celsius;
  std::string text;
  if (std::ranges::any_of(axes, &AxisCorrection::states_offset))
    text = line(fmt::format("INS_{}{}_CALTEMP", gyro ? "GYR" : "ACC", index), offset_temperature(c) - zero_celsius);
  for (std::size_t power = 0; power < 3; ++power)
    for (std::size_t i = 0; i < 3; ++i)
      text += line(fmt::format("INS_TCAL{}_{}{}_{}", index, gyro ? "GYR" : "ACC", power + 1, "XYZ"[i]),
                   coefficients(axes[i], celsius)[power]);
  return text;
}

/// What the vehicle would refuse or take for a fault.
void check(const std::array<AxisCorrection, 3>& axes, Problems& problems) {
  constexpr double most_offset = 3.5, least_scale = 0.8, most_scale = 1.2;
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::abs(axes[i].offset) > most_offset)
      problems.push_back(
          say("the offset {:.3g} m/s^2 of accelerometer_{} is beyond the {} m/s^2 that ArduPilot "
              "accepts",
              axes[i].offset, "xyz"[i], most_offset));
    if (axes[i].scale < least_scale || axes[i].scale > most_scale)
      problems.push_back(
          say("the scale {:.3g} of accelerometer_{} is outside of the {} to {} that ArduPilot "
              "accepts",
              axes[i].scale, "xyz"[i], least_scale, most_scale));
  }
}

/// INS_ACCOFFS_X and INS_GYROFFS_X of the first IMU, INS_ACC2OFFS_X and INS_GYR2OFFS_X of the second.
std::string triad(const ImuCalibration& c, const Settings& settings, bool gyro, Problems& problems) {
  const int index = settings.integer("index");
  auto axes = corrections(c, gyro, problems);
  for (auto& axis : axes)
    if (axis.states_offset() && problems.empty() && !axis.temperature.empty())
      axis.offset += polynomial_without_constant(axis.temperature, offset_temperature(c) - c.reference_temperature);
  if (!gyro) check(axes, problems);
  const std::string number = index == 1 ? "" : std::to_string(index);
  const std::string prefix = "INS_" + std::string(gyro ? "GYR" : "ACC") + number;
  const std::string offsets = gyro && index == 1 ? "INS_GYROFFS_" : prefix + "OFFS_";
  std::string text;
  if (const char* id = gyro ? "gyro_id" : "accelerometer_id"; settings.has(id))
    text += fmt::format("{}_ID,{}\n", prefix, settings.integer(id));
  for (std::size_t i = 0; i < 3; ++i)
    if (axes[i].states_offset()) text += line(offsets + "XYZ"[i], axes[i].offset);
  for (std::size_t i = 0; i < 3 && !gyro; ++i)
    if (axes[i].states_scale()) text += line(prefix + "SCAL_" + "XYZ"[i], axes[i].scale);
  return has_temperature(axes) ? text + temperatures(c, axes, gyro, index) : text;
}

std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  require_calibration(c, "ardupilot");
  Problems problems;
  std::string text;
  for (const bool gyro : {false, true})
    if ((gyro ? c.gyros : c.accelerometers).calibrated) text += triad(c, settings, gyro, problems);
  if (text.find("INS_TCAL") != std::string::npos)
    text += fmt::format("INS_TCAL{0}_ENABLE,1\n", settings.integer("index")) +
            line(fmt::format("INS_TCAL{}_TMIN", settings.integer("index")), c.coldest - zero_celsius) +
            line(fmt::format("INS_TCAL{}_TMAX", settings.integer("index")), c.hottest - zero_celsius);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return commented(header, "#") + text;
}

}  // namespace

extern const Export ardupilot{
    .name = "ardupilot",
    .summary = "ArduPilot: parameters INS for Mission Planner",
    .formula =
        "accelerometer = (raw - P(T) + P(CALTEMP) - OFFS) SCAL, gyro = raw - P(T) + P(CALTEMP) - OFFS; P = (c_1 + "
        "(c_2 + c_3 d) d) d 1e-6 with d = T - 35 degC, T limited to TMIN..TMAX",
    .units = "m/s^2, rad/s, degC; polynomials in 1e-6 of these; stored as 32-bit floats",
    .frame = "axes of the sensor after its own rotation, before that of the board (forward, right, down)",
    .source =
        "github.com/ArduPilot/ardupilot: libraries/AP_InertialSensor/AP_InertialSensor_Backend.cpp, "
        "AP_InertialSensor_tempcal.cpp",
    .comment = "#",
    .extension = ".param",
    .carries = autopilot_terms,
    .estimates = no_terms,
    .takes_counts = false,
    .options = options,
    .write = write};

}  // namespace tumble::exports::ardupilot
