#include "tumble/exchange/exports/writing/autopilot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/sentence.hpp"

namespace tumble::writing {

std::array<AxisCorrection, 3> corrections(const ImuCalibration& calibration, bool gyro, Problems& problems) {
  constexpr std::size_t most_powers = 3;
  const TriadCalibration& t = gyro ? calibration.gyros : calibration.accelerometers;
  std::array<AxisCorrection, 3> axes;
  for (std::size_t i = 0; i < 3; ++i) {
    const double k = t.response(i, i);
    const AxisThermal& thermal = t.thermal[i];
    axes[i] = {t.bias[i], 1.0 / k, thermal.output, t.axes[i]};
    auto& powers = axes[i].temperature;
    powers.resize(std::max(powers.size(), thermal.bias.size()), 0.0);
    for (std::size_t n = 0; n < thermal.bias.size(); ++n) powers[n] += k * thermal.bias[n];
    if (powers.size() > most_powers)
      problems.push_back(say(
          "{}_thermal_bias has {} powers of the temperature, but the file carries {}; "
          "--drop {}_thermal_bias, or identify with a lower order",
          Name{gyro ? "gyro" : "accelerometer"}, powers.size(), most_powers, Name{gyro ? "gyro" : "accelerometer"}));
  }
  if (has_temperature(axes) && std::isnan(calibration.coldest))
    problems.emplace_back("the result does not say which temperatures it covers, which TMIN and TMAX must state");
  return axes;
}

bool has_temperature(const std::array<AxisCorrection, 3>& axes) {
  return std::ranges::any_of(axes, [](const AxisCorrection& axis) { return !axis.temperature.empty(); });
}

std::vector<std::string> autopilot_terms() {
  return {"accelerometer_bias", "accelerometer_scale_factor", "accelerometer_thermal_bias", "gyro_bias",
          "gyro_thermal_bias"};
}

}  // namespace tumble::writing
