#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"

namespace tumble::exports::gazebo {
namespace {

using namespace writing;

std::vector<Option> options() {
  return {rate_option("rate of the samples, on which stddev depends"),
          quantity("correlation_time", "s")
              .above(0)
              .otherwise("1e6 s")
              .says("correlation time of the bias where the results state K alone; much longer than the simulation")};
}

/// Standard uncertainty of a bias; 0 where no result has it.
double bias_sd(const ImuCalibration& c, const std::string& name) {
  for (const auto& block : c.parameters) {
    const auto match = std::ranges::find(block.names, name);
    const auto p = static_cast<std::size_t>(match - block.names.begin());
    if (match != block.names.end() && p < block.covariance.rows)
      return std::sqrt(std::max(0.0, block.covariance(p, p)));
  }
  return 0.0;
}

/// Density and correlation time of the bias: of a Gauss-Markov process sigma sqrt(2/T), else K.
std::pair<double, double> dynamic_bias(const AxisNoise& axis, double time) {
  if (axis.markov_time > 0.0) return {axis.markov_sd * std::sqrt(2.0 / axis.markov_time), axis.markov_time};
  return {std::isnan(axis.walk) ? 0.0 : axis.walk, time};
}

std::string axis_of(const ImuCalibration& c, bool gyro, std::size_t i, const Noises& n, const Settings& settings) {
  const AxisNoise& axis = (gyro ? c.gyros : c.accelerometers).noise[i];
  const auto [density, time] = dynamic_bias(axis, settings.number("correlation_time"));
  const std::string name = std::string(gyro ? "gyro_" : "accelerometer_") + "xyz"[i] + "_bias";
  const double own = std::isnan(axis.white) ? (gyro ? n.gyro : n.accelerometer).white : axis.white;
  return fmt::format(
      "    <{0}>\n      <noise type=\"gaussian\">\n        <mean>0.0</mean>\n        <stddev>{1}</stddev>\n"
      "        <bias_mean>0.0</bias_mean>\n        <bias_stddev>{2}</bias_stddev>\n"
      "        <dynamic_bias_stddev>{3}</dynamic_bias_stddev>\n"
      "        <dynamic_bias_correlation_time>{4}</dynamic_bias_correlation_time>\n      </noise>\n    </{0}>\n",
      "xyz"[i], real(own * std::sqrt(n.rate)), real(bias_sd(c, name)), real(density), real(time));
}

std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const Noises n = noises_of(c, settings, "gazebo", {.rate = true});
  std::string text = "<!--\n";
  for (const auto& line : header) text += "  " + line + "\n";
  text +=
      "  Gazebo flips the sign of a drawn bias with probability 1/2: a calibrated bias cannot be "
      "reproduced\n-->\n<imu>\n";
  for (const bool gyro : {true, false}) {
    text += gyro ? "  <angular_velocity>\n" : "  <linear_acceleration>\n";
    for (std::size_t i = 0; i < 3; ++i) text += axis_of(c, gyro, i, n, settings);
    text += gyro ? "  </angular_velocity>\n" : "  </linear_acceleration>\n";
  }
  return text + "</imu>\n";
}

}  // namespace

extern const Export gazebo{.name = "gazebo",
                           .summary = "Gazebo: noise of an <imu> sensor in SDF",
                           .formula =
                               "a sample has the noise stddev = N sqrt(rate); the bias is a Gauss-Markov process whose "
                               "dynamic_bias_stddev is a density, K or sigma sqrt(2/T)",
                           .units = "rad/s, m/s^2; dynamic_bias_stddev per sqrt(Hz)",
                           .frame = "axes of the calibration",
                           .source = "github.com/gazebosim/gz-sensors: src/GaussianNoiseModel.cc; sdformat.org",
                           .comment = "<!--",
                           .extension = ".sdf",
                           .carries = no_terms,
                           .estimates = no_terms,
                           .takes_counts = false,
                           .options = options,
                           .write = write};

}  // namespace tumble::exports::gazebo
