#include <fmt/format.h>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/factor.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::exports::kalibr {
namespace {

using namespace writing;

std::vector<std::string> carries() {
  auto names = terms_ending({"scale_factor", "misalignment"});
  names.emplace_back("gyro_acceleration_sensitivity");
  return names;
}

std::vector<Option> options() {
  return {rate_option("rate of the samples, which Kalibr requires"),
          text("rostopic").otherwise("/imu0").says("topic of the IMU")};
}

std::string noises(const ImuCalibration& calibration, const Settings& settings, const std::string& indent) {
  const Noises n = noises_of(calibration, settings, "kalibr", {.walks = true, .rate = true});
  return fmt::format(
      "{0}accelerometer_noise_density: {1}   # m/s^2/sqrt(Hz), N\n"
      "{0}accelerometer_random_walk: {2}   # m/s^3/sqrt(Hz), K\n"
      "{0}gyroscope_noise_density: {3}   # rad/s/sqrt(Hz), N\n"
      "{0}gyroscope_random_walk: {4}   # rad/s^2/sqrt(Hz), K\n"
      "{0}rostopic: {5}\n"
      "{0}update_rate: {6}   # Hz\n",
      indent, real(n.accelerometer.white), real(n.accelerometer.walk), real(n.gyro.white), real(n.gyro.walk),
      topic_of(settings), real(n.rate));
}

/// K_a = M_a Q defines the frame i = Q body; K_g Q' = M_g C, and A C = G Q'.
std::string chain(const ImuCalibration& calibration, const Settings& settings) {
  const Factored force = lower_factor(calibration.accelerometers.response, "accelerometers");
  const Matrix3 back = transposed(force.rotation);
  const Factored rate = lower_factor(calibration.gyros.response * back, "gyros");
  const Matrix3 a = calibration.gyros.by_force * back * transposed(rate.rotation);
  return fmt::format("# rotation from the axes of the calibration to those of this file (T_i_b): {:.6g} deg\n",
                     angle_of(force.rotation) / degree) +
         "imu0:\n  T_i_b:\n" + yaml_transform(force.rotation, "  ") + noises(calibration, settings, "  ") +
         "  accelerometers:\n    M:\n" + yaml_rows(force.triangle, "    ") + "  gyroscopes:\n    A:\n" +
         yaml_rows(a, "    ") + "    C_gyro_i:\n" + yaml_rows(rate.rotation, "    ") + "    M:\n" +
         yaml_rows(rate.triangle, "    ") + "  model: scale-misalignment\n  time_offset: 0.0\n";
}

/// imu.yaml where there is noise alone, else the chain as Kalibr's own results have it.
std::string write(const ImuCalibration& calibration, const Settings& settings, const std::vector<std::string>& header) {
  const bool deterministic = calibration.accelerometers.calibrated || calibration.gyros.calibrated;
  return commented(header, "#") + (deterministic ? chain(calibration, settings) : noises(calibration, settings, ""));
}

}  // namespace

extern const Export kalibr{
    .name = "kalibr",
    .summary = "Kalibr: imu.yaml of the noise, or imu0 of a chain with scale factors and misalignments",
    .formula =
        "w_m = M_g C_gyro_i w + A C_gyro_i a + b_g + n; a_m = M_a a + b_a + n; M lower triangular, C_gyro_i a "
        "rotation; noise of one sample = density sqrt(rate)",
    .units = "rad/s, m/s^2; densities per sqrt(Hz), two-sided",
    .frame =
        "axes i of this file: the accelerometer x along x, y in the plane xy; T_i_b turns the axes of the "
        "calibration into them",
    .source = "github.com/ethz-asl/kalibr: kalibr_common/ConfigReader.py, kalibr_imu_camera_calibration/IccSensors.py",
    .comment = "#",
    .extension = ".yaml",
    .carries = carries,
    .estimates = estimated_biases,
    .takes_counts = false,
    .options = options,
    .write = write};

}  // namespace tumble::exports::kalibr
