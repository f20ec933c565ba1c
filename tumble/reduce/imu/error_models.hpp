#pragma once

#include <vector>

#include "tumble/reduce/compensate.hpp"
#include "tumble/reduce/imu/sensors.hpp"

/// The channels of a calibrated unit as error models that depend on each other.
namespace tumble::imu {

struct CalibratedOutput {
  Kind kind = Kind::accelerometer;
  std::size_t axis = 0;
  ErrorModel model;
};

struct CalibratedUnit {
  std::vector<CalibratedOutput> outputs;  ///< triad by triad
  Findings findings;                      ///< triads that were calibrated but not recorded
};

/// The triads that the result calibrated and the recording holds; all that were calibrated where it holds none.
///
///   y_i = (1 + k_i) u_i + sum_j m_ij u_j + sum_j g_ij f_j + b_i            where k_i is a parameter
///   y_i = K_i (u_i + sum_j m_ij u_j + sum_j g_ij f_j) + b_i                where K_i is, of raw counts
///
/// Terms are those of the model `imu`, by the names of the parameters. Scale [SI for one SI unit of the channel]: the
/// sampling rate [Hz] of increments, else 1.
CalibratedUnit error_models(const Estimate& estimate, const Recording& recording);

/// Subtracts them together, with the findings of the unit first. Throws as tumble::compensate.
Compensation compensate(CalibratedUnit unit, const Estimate& estimate, const Recording& recording, const Plan* plan);

}  // namespace tumble::imu
