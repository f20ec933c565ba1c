#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/units/error.hpp"

namespace tumble::exports::ros_imu_calib {
namespace {

using namespace writing;

std::vector<std::string> carries() {
  return {"accelerometer_bias", "accelerometer_scale_factor", "accelerometer_misalignment"};
}

/// The node takes the mean of the gyros when it starts.
std::vector<std::string> estimates() { return {"gyro_bias", "gyro_thermal_bias"}; }

std::vector<Option> options() { return {}; }

std::string write(const ImuCalibration& c, const Settings&, const std::vector<std::string>& header) {
  if (!c.accelerometers.calibrated)
    throw Error(Error::Kind::bad_input, "ros_imu_calib: the results hold no calibration of the accelerometers");
  const Matrix3 sm = inverse(c.accelerometers.response);
  const Vector3 bias = sm * c.accelerometers.bias;
  std::vector<std::string> elements;
  for (std::size_t i = 0; i < 9; ++i) elements.push_back(real(sm(i / 3, i % 3)));
  return commented(header, "#") + fmt::format("SM:\n  - {}\nbias:\n  - {}\n  - {}\n  - {}\n",
                                              fmt::join(elements, "\n  - "), real(bias.x), real(bias.y), real(bias.z));
}

}  // namespace

extern const Export ros_imu_calib{.name = "ros_imu_calib",
                                  .summary = "ROS package imu_calib: yaml of its accelerometer calibration",
                                  .formula = "corrected = SM raw - bias: the bias is subtracted after the matrix",
                                  .units = "m/s^2",
                                  .frame = "axes of the calibration",
                                  .source = "github.com/dpkoch/imu_calib: src/accel_calib/accel_calib.cpp",
                                  .comment = "#",
                                  .extension = ".yaml",
                                  .carries = carries,
                                  .estimates = estimates,
                                  .takes_counts = false,
                                  .options = options,
                                  .write = write};

}  // namespace tumble::exports::ros_imu_calib
