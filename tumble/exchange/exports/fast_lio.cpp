#include <fmt/format.h>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/math/square.hpp"

namespace tumble::exports::fast_lio {
namespace {

using namespace writing;

std::vector<Option> options() { return {rate_option("rate of the samples, on which the values depend")}; }

std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const Noises n = noises_of(c, settings, "fast_lio", {.walks = true, .rate = true});
  const double rate = n.rate;
  const auto variance = [rate](double density) { return real(square(density) * rate); };
  return commented(header, "#") + fmt::format("# variances: N^2 rate and K^2 rate at {} Hz\n", real(rate)) +
         fmt::format(
             "mapping:\n    acc_cov: {}   # (m/s^2)^2\n    gyr_cov: {}   # (rad/s)^2\n"
             "    b_acc_cov: {}   # (m/s^3)^2\n    b_gyr_cov: {}   # (rad/s^2)^2\n",
             variance(n.accelerometer.white), variance(n.gyro.white), variance(n.accelerometer.walk),
             variance(n.gyro.walk));
}

}  // namespace

extern const Export fast_lio{
    .name = "fast_lio",
    .summary = "FAST-LIO and FAST-LIO2: variances of the IMU under mapping:",
    .formula =
        "in a step the covariance grows by dt^2 Q: acc_cov, gyr_cov are variances of a sample, b_acc_cov, "
        "b_gyr_cov those of the rate at which the bias changes",
    .units = "(m/s^2)^2, (rad/s)^2, (m/s^3)^2, (rad/s^2)^2",
    .frame = "axes of the calibration",
    .source = "github.com/hku-mars/FAST_LIO: include/IKFoM_toolkit/esekfom/esekfom.hpp, src/IMU_Processing.hpp",
    .comment = "#",
    .extension = ".yaml",
    .carries = no_terms,
    .estimates = estimated_biases,
    .takes_counts = false,
    .options = options,
    .write = write};

}  // namespace tumble::exports::fast_lio
