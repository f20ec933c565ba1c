#include <fmt/format.h>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"

namespace tumble::exports::orbslam3 {
namespace {

using namespace writing;

std::vector<Option> options() { return {rate_option("rate of the samples (IMU.Frequency)")}; }

std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const Noises n = noises_of(c, settings, "orbslam3", {.walks = true, .rate = true});
  return "%YAML:1.0\n\n" + commented(header, "#") +
         fmt::format(
             "IMU.NoiseGyro: {}   # rad/s/sqrt(Hz)\nIMU.NoiseAcc: {}   # m/s^2/sqrt(Hz)\n"
             "IMU.GyroWalk: {}   # rad/s^2/sqrt(Hz)\nIMU.AccWalk: {}   # m/s^3/sqrt(Hz)\n"
             "IMU.Frequency: {}   # Hz\n",
             real(n.gyro.white), real(n.accelerometer.white), real(n.gyro.walk), real(n.accelerometer.walk),
             real(n.rate));
}

}  // namespace

extern const Export orbslam3{
    .name = "orbslam3",
    .summary = "ORB-SLAM3: the IMU block of a settings file",
    .formula = "noise of a sample = Noise sqrt(Frequency); the bias grows by Walk/sqrt(Frequency) in a step",
    .units = "rad/s, m/s^2; densities per sqrt(Hz), two-sided",
    .frame = "axes of the calibration",
    .source = "github.com/UZ-SLAMLab/ORB_SLAM3: src/Tracking.cc, Examples/Monocular-Inertial/EuRoC.yaml",
    .comment = "#",
    .extension = ".yaml",
    .carries = no_terms,
    .estimates = estimated_biases,
    .takes_counts = false,
    .options = options,
    .write = write};

}  // namespace tumble::exports::orbslam3
