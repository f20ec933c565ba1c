#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/reduce/imu/sensors.hpp"

/// The channels of a calibrated unit as error models that depend on each other.
namespace tumble::imu {

/// Range [SI] of a term's regressor over the data.
using RangeOf = std::function<std::pair<double, double>(const Term& term, Kind kind)>;

/// Error models of each triad that the result calibrated:
///
///   y_i = (1 + k_i) u_i + sum_j m_ij u_j + sum_j g_ij f_j + b_i            where k_i is a parameter
///   y_i = K_i (u_i + sum_j m_ij u_j + sum_j g_ij f_j) + b_i                where K_i is, of raw counts
///
/// Terms are those of the model `imu`, by the names of the parameters.
std::vector<OutputModel> models_of(const Estimate& estimate, const RangeOf& range);

/// An output whose input axis is a row of direction cosines, with unit length and this sign [1] of its own cosine:
///
///   y_i = K_i R_i u + sum_j g_ij f_j + b_i
///
/// Given     rate, force  [rad/s], [m/s^2] greatest that the test covered
OutputModel directed_model(const Estimate& estimate, Kind kind, std::size_t axis, double sign, const Vector3& rate,
                           const Vector3& force);

/// The model holds where rates and specific forces of both triads lie within these [rad/s], [m/s^2] on both sides of
/// zero; noise is not counted. All zero: the test shows no range.
void set_covered(const Vector3& rate, const Vector3& force, OutputModel& model);

}  // namespace tumble::imu
