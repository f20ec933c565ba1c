#include <cmath>
#include <nlohmann/json.hpp>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::exports::airsim {
namespace {

using namespace writing;
using Json = nlohmann::ordered_json;

std::vector<Option> options() {
  return {quantity("gyro_time", "s").above(0).otherwise("500 s").says("GyroBiasStabilityTau"),
          quantity("accelerometer_time", "s").above(0).otherwise("800 s").says("AccelBiasStabilityTau")};
}

/// The walk density is stability/sqrt(tau); there is no return to the mean.
std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const Noises n = noises_of(c, settings, "airsim", {.walks = true});
  const double gyro_time = settings.number("gyro_time"), force_time = settings.number("accelerometer_time");
  const Json imu{{"SensorType", 2},
                 {"Enabled", true},
                 {"GenerateNoise", true},
                 {"AngularRandomWalk", Unit::parse("deg/sqrt(h)").from_si(n.gyro.white)},
                 {"GyroBiasStabilityTau", gyro_time},
                 {"GyroBiasStability", Unit::parse("deg/h").from_si(n.gyro.walk * std::sqrt(gyro_time))},
                 {"VelocityRandomWalk", n.accelerometer.white / (1e3 * micro_g)},
                 {"AccelBiasStabilityTau", force_time},
                 {"AccelBiasStability", n.accelerometer.walk * std::sqrt(force_time) / micro_g}};
  return Json{{"Comment", header}, {"Sensors", {{"Imu", imu}}}}.dump(2) + "\n";
}

}  // namespace

extern const Export airsim{
    .name = "airsim",
    .summary = "AirSim: the Imu block of settings.json",
    .formula =
        "white noise: AngularRandomWalk and VelocityRandomWalk; density of the walk = stability/sqrt(tau), without "
        "return to the mean",
    .units = "deg/sqrt(h), deg/h, s; VelocityRandomWalk in mg/sqrt(Hz), AccelBiasStability in ug",
    .frame = "axes of the calibration; AirSim has forward, right, down",
    .source = "github.com/microsoft/AirSim: AirLib/include/sensors/imu/ImuSimple.hpp, ImuSimpleParams.hpp",
    .comment = "",
    .extension = ".json",
    .carries = no_terms,
    .estimates = no_terms,
    .takes_counts = false,
    .options = options,
    .write = write};

}  // namespace tumble::exports::airsim
