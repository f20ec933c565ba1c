#include <fmt/format.h>

#include <cmath>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"

namespace tumble::exports::vins {
namespace {

using namespace writing;

std::vector<Option> options() {
  return {rate_option("rate of the samples, on which the values depend"),
          text("rostopic").otherwise("/imu0").says("topic of the IMU"),
          quantity("gravity", "m/s^2").otherwise("9.80665 m/s^2").above(0).says("gravity of the place (g_norm)")};
}

/// With two independent values a step, each for half of it, the variance of the step's mean is acc_n^2/2 = N^2 rate.
std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const Noises n = noises_of(c, settings, "vins", {.walks = true, .rate = true});
  const double rate = n.rate, white = std::sqrt(2.0 * rate), walk = std::sqrt(rate);
  return "%YAML:1.0\n\n" + commented(header, "#") +
         fmt::format("# acc_n = N sqrt(2 rate), acc_w = K sqrt(rate) at {} Hz\n", real(rate)) +
         fmt::format(
             "imu_topic: \"{}\"\nacc_n: {}   # m/s^2\ngyr_n: {}   # rad/s\nacc_w: {}   # m/s^3\n"
             "gyr_w: {}   # rad/s^2\ng_norm: {}   # m/s^2\n",
             topic_of(settings), real(white * n.accelerometer.white), real(white * n.gyro.white),
             real(walk * n.accelerometer.walk), real(walk * n.gyro.walk), real(settings.number("gravity")));
}

}  // namespace

extern const Export vins{
    .name = "vins",
    .summary = "VINS-Mono and VINS-Fusion: noise of a step of the preintegration",
    .formula =
        "two samples of sd acc_n (gyr_n) act for half a step each; the bias grows by acc_w dt (gyr_w dt) in a "
        "step, acc_w being a standard deviation",
    .units = "m/s^2 and rad/s; walks m/s^3 and rad/s^2, all of one step",
    .frame = "axes of the calibration",
    .source = "github.com/HKUST-Aerial-Robotics/VINS-Mono: vins_estimator/src/factor/integration_base.h",
    .comment = "#",
    .extension = ".yaml",
    .carries = no_terms,
    .estimates = estimated_biases,
    .takes_counts = false,
    .options = options,
    .write = write};

}  // namespace tumble::exports::vins
