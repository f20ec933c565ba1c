#include <fmt/format.h>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"

namespace tumble::exports::lio_sam {
namespace {

using namespace writing;

std::vector<Option> options() {
  return {text("rostopic").otherwise("imu_raw").says("topic of the IMU"),
          quantity("gravity", "m/s^2").otherwise("9.80511 m/s^2").above(0).says("gravity of the place (imuGravity)")};
}

std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const Noises n = noises_of(c, settings, "lio_sam", {.walks = true});
  return commented(header, "#") + fmt::format(
                                      "lio_sam:\n  imuTopic: \"{}\"\n  imuAccNoise: {}   # m/s^2/sqrt(Hz)\n"
                                      "  imuGyrNoise: {}   # rad/s/sqrt(Hz)\n  imuAccBiasN: {}   # m/s^3/sqrt(Hz)\n"
                                      "  imuGyrBiasN: {}   # rad/s^2/sqrt(Hz)\n  imuGravity: {}   # m/s^2\n",
                                      topic_of(settings), real(n.accelerometer.white), real(n.gyro.white),
                                      real(n.accelerometer.walk), real(n.gyro.walk), real(settings.number("gravity")));
}

}  // namespace

extern const Export lio_sam{
    .name = "lio_sam",
    .summary = "LIO-SAM: noise of the IMU in params.yaml",
    .formula = "the covariance of a sample is imuAccNoise^2/dt; the bias grows by imuAccBiasN sqrt(dt)",
    .units = "rad/s, m/s^2; densities per sqrt(Hz), two-sided",
    .frame = "axes of the calibration; extrinsicRot turns them to those of the lidar",
    .source = "github.com/TixiaoShan/LIO-SAM: src/imuPreintegration.cpp, config/params.yaml",
    .comment = "#",
    .extension = ".yaml",
    .carries = no_terms,
    .estimates = estimated_biases,
    .takes_counts = false,
    .options = options,
    .write = write};

}  // namespace tumble::exports::lio_sam
