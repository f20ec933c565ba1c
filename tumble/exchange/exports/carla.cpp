#include <fmt/format.h>

#include <cmath>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"

namespace tumble::exports::carla {
namespace {

using namespace writing;

std::vector<Option> options() { return {rate_option("rate of the samples (1/sensor_tick)")}; }

std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const Noises n = noises_of(c, settings, "carla", {.rate = true});
  const double rate = n.rate;
  std::string text = commented(header, "#") + "IMU_ATTRIBUTES = {\n";
  text += fmt::format("    \"sensor_tick\": \"{}\",\n", real(1.0 / rate));
  for (const bool gyro : {false, true})
    for (std::size_t i = 0; i < 3; ++i) {
      const double own = (gyro ? c.gyros : c.accelerometers).noise[i].white;
      const double white = std::isnan(own) ? (gyro ? n.gyro : n.accelerometer).white : own;
      text += fmt::format("    \"noise_{}_stddev_{}\": \"{}\",\n", gyro ? "gyro" : "accel", "xyz"[i],
                          real(white * std::sqrt(rate)));
    }
  return text + "}\n# for name, value in IMU_ATTRIBUTES.items(): blueprint.set_attribute(name, value)\n";
}

}  // namespace

extern const Export carla{.name = "carla",
                          .summary = "CARLA: attributes of sensor.other.imu, as a Python dictionary",
                          .formula = "a sample has the noise stddev = N sqrt(rate); CARLA has no walk of the bias",
                          .units = "rad/s, m/s^2",
                          .frame = "CARLA's axes are left-handed (forward, right, up); the noise does not depend on it",
                          .source =
                              "github.com/carla-simulator/carla: "
                              "Unreal/CarlaUE4/Plugins/Carla/Source/Carla/Sensor/InertialMeasurementUnit.cpp",
                          .comment = "#",
                          .extension = ".py",
                          .carries = no_terms,
                          .estimates = no_terms,
                          .takes_counts = false,
                          .options = options,
                          .write = write};

}  // namespace tumble::exports::carla
