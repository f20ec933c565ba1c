#include <fmt/format.h>

#include <cmath>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/autopilot.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/units/error.hpp"

namespace tumble::exports::px4 {
namespace {

using namespace writing;

constexpr double zero_celsius = 273.15;

std::vector<Option> options() {
  return {integer("index").between(0, 3).otherwise("0").says("number of the sensor: CAL_ACC0, CAL_GYRO0"),
          integer("accelerometer_id").says("CAL_ACCn_ID: the device that the calibration is of"),
          integer("gyro_id").says("CAL_GYROn_ID: the device that the calibration is of")};
}

std::string integer_line(const std::string& name, int value) { return fmt::format("1\t1\t{}\t{}\t6\n", name, value); }

std::string float_line(const std::string& name, double value) {
  return fmt::format("1\t1\t{}\t{}\t9\n", name, real_of_float(value));
}

/// Identifier, offsets and, of accelerometers, scales.
std::string constants(const std::array<AxisCorrection, 3>& axes, const std::string& prefix, int id, bool scales) {
  std::string text = integer_line(prefix + "_ID", id);
  for (std::size_t i = 0; i < 3; ++i)
    if (axes[i].states_offset()) text += float_line(fmt::format("{}_{}OFF", prefix, "XYZ"[i]), axes[i].offset);
  for (std::size_t i = 0; i < 3 && scales; ++i)
    if (axes[i].states_scale()) text += float_line(fmt::format("{}_{}SCALE", prefix, "XYZ"[i]), axes[i].scale);
  return text;
}

/// The polynomials without their constants, which are in the offsets: X0 = 0 at TREF.
std::string temperatures(const ImuCalibration& c, const std::array<AxisCorrection, 3>& axes, char letter, int index,
                         int id) {
  if (!has_temperature(axes)) return "";
  const std::string prefix = fmt::format("TC_{}{}", letter, index);
  std::string text = integer_line(fmt::format("TC_{}_ENABLE", letter), 1) + integer_line(prefix + "_ID", id) +
                     float_line(prefix + "_TMIN", c.coldest - zero_celsius) +
                     float_line(prefix + "_TMAX", c.hottest - zero_celsius) +
                     float_line(prefix + "_TREF", c.reference_temperature - zero_celsius);
  for (std::size_t power = 0; power <= 3; ++power)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& powers = axes[i].temperature;
      text += float_line(fmt::format("{}_X{}_{}", prefix, power, i),
                         power == 0 || power > powers.size() ? 0.0 : powers[power - 1]);
    }
  return text;
}

/// The vehicle ignores a calibration whose identifier is not that of its sensor.
int id_of(const Settings& settings, const char* name, const char* parameter, Problems& problems) {
  if (settings.has(name)) return settings.integer(name);
  problems.push_back(say("px4 needs {0}, the value of {1} of your vehicle: --set {0}=1310988", name, parameter));
  return 0;
}

/// The vehicle keeps its old scales where one of the three is not above 0.
void check_scales(const std::array<AxisCorrection, 3>& axes, const std::string& prefix, Problems& problems) {
  for (std::size_t i = 0; i < 3; ++i)
    if (axes[i].states_scale() && !(axes[i].scale > 0.0))
      problems.push_back(
          say("{}_{}SCALE would be {:.3g}, but PX4 takes scales above 0 alone: accelerometer_{} is reversed; "
              "correct the wiring in [channels]",
              Name{prefix}, "XYZ"[i], axes[i].scale, "xyz"[i]));
}

std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  require_calibration(c, "px4");
  Problems problems;
  const int index = settings.integer("index");
  std::string text = commented(header, "#") +
                     "# offsets are in the axes of the sensor, before it is turned into those of the board\n"
                     "#\n# Vehicle-Id Component-Id Name Value Type\n";
  for (const bool gyro : {false, true}) {
    if (!(gyro ? c.gyros : c.accelerometers).calibrated) continue;
    const std::string prefix = fmt::format("CAL_{}{}", gyro ? "GYRO" : "ACC", index);
    const auto axes = corrections(c, gyro, problems);
    if (!gyro) check_scales(axes, prefix, problems);
    const int id = id_of(settings, gyro ? "gyro_id" : "accelerometer_id", (prefix + "_ID").c_str(), problems);
    text += constants(axes, prefix, id, !gyro) + temperatures(c, axes, gyro ? 'G' : 'A', index, id);
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return text;
}

}  // namespace

extern const Export px4{
    .name = "px4",
    .summary = "PX4: parameters CAL_ACC, CAL_GYRO and TC for QGroundControl",
    .formula =
        "accelerometer = (raw - thermal(T) - OFF) SCALE, gyro = raw - thermal(T) - OFF; thermal = X1 d + X2 d^2 + "
        "X3 d^3 with d = T - TREF, T limited to TMIN..TMAX; X0 is 0, the constants are in CAL",
    .units = "m/s^2, rad/s, degC; stored as 32-bit floats",
    .frame = "axes of the sensor before its rotation to the board (forward, right, down)",
    .source = "github.com/PX4/PX4-Autopilot: src/lib/sensor_calibration, src/modules/temperature_compensation",
    .comment = "#",
    .extension = ".params",
    .carries = autopilot_terms,
    .estimates = no_terms,
    .takes_counts = false,
    .options = options,
    .write = write};

}  // namespace tumble::exports::px4
