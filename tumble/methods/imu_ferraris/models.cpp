#include "tumble/methods/imu_ferraris/report.hpp"
#include "tumble/reduce/imu/error_models.hpp"

namespace tumble::imu_ferraris {

std::vector<OutputModel> models_of(const Estimate& estimate, const Calibration& calibration, const Recorded& recorded) {
  std::vector<OutputModel> models;
  const auto [rate, force] = greatest(calibration, recorded);
  for (const imu::Kind kind : imu::kinds)
    for (std::size_t i = 0; i < 3 && (kind == imu::Kind::accelerometer || calibration.gyros); ++i) {
      const double own = (kind == imu::Kind::gyro ? calibration.r_g : calibration.r_a)(i, i);
      models.push_back(imu::directed_model(estimate, kind, i, own < 0.0 ? -1.0 : 1.0, rate, force));
    }
  return models;
}

}  // namespace tumble::imu_ferraris
