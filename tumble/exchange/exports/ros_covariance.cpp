#include <fmt/format.h>

#include <cmath>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"

namespace tumble::exports::ros_covariance {
namespace {

using namespace writing;

std::vector<Option> options() { return {rate_option("rate of the samples, on which the variances depend")}; }

std::string covariance(const TriadCalibration& t, double white, double rate) {
  const Vector3 each = of_each_axis(t, &AxisNoise::white, white), v = rate * scaled(each, each);
  return fmt::format("[{}, 0.0, 0.0, 0.0, {}, 0.0, 0.0, 0.0, {}]", real(v.x), real(v.y), real(v.z));
}

std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const Noises n = noises_of(c, settings, "ros_covariance", {.rate = true});
  const double rate = n.rate;
  return commented(header, "#") + fmt::format(
                                      "orientation_covariance: [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]\n"
                                      "angular_velocity_covariance: {}\nlinear_acceleration_covariance: {}\n",
                                      covariance(c.gyros, n.gyro.white, rate),
                                      covariance(c.accelerometers, n.accelerometer.white, rate));
}

}  // namespace

extern const Export ros_covariance{
    .name = "ros_covariance",
    .summary = "ROS sensor_msgs/Imu: covariances of the samples",
    .formula = "variance of a sample = N^2 rate, row by row; the orientation is marked as not estimated by -1",
    .units = "(rad/s)^2, (m/s^2)^2",
    .frame = "axes of the calibration",
    .source = "docs.ros.org/en/noetic/api/sensor_msgs/html/msg/Imu.html",
    .comment = "#",
    .extension = ".yaml",
    .carries = no_terms,
    .estimates = estimated_biases,
    .takes_counts = false,
    .options = options,
    .write = write};

}  // namespace tumble::exports::ros_covariance
