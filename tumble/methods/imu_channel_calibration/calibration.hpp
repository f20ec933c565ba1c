#pragma once

#include <map>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/reduce/linear/linear.hpp"

/// Three channels of one kind in the form of the whole-unit model
///
///   A = M N/(K_m H) - nabla,   M = 1 + [dK_x E_xy E_xz; E_yx dK_y E_yz; E_zx E_zy dK_z]                    (3.4)
///
/// See Lu Hanjie, Liu Yabin, Zhou Qiang, dynamic test of linear accelerometers, 2019
namespace tumble::imu_channel_calibration {

using imu::Kind;
using imu::kinds;
using imu::letters;
using imu::Reading;
using imu::reading_of;
using imu::role_of;

struct Sorted {
  Evidence whole;                         ///< recordings without a plan of their own, without segments for the check
  Evidence check;                         ///< these recordings, segments for the check only; none: no recording
  std::map<std::string, Evidence> alone;  ///< by role; the channel plays the role "accelerometer" or "gyro"
  bool gyros = false;                     ///< calibrated as well
  Findings findings;
};

/// A recording with a plan of its own is of the channels that its [channels] name; the others are of the whole unit.
/// Throws Error::bad_data that names everything that is missing.
Sorted sorted(const Evidence& evidence);

/// The evidence without segments in which the rig turns.
Evidence at_rest(const Evidence& evidence);

inline constexpr std::size_t per_axis = 4;          ///< nabla_i, dK_i, and the two E of its row
inline constexpr std::size_t terms = 3 * per_axis;  ///< of three channels

/// Index of a term: which = 0 bias, 1 scale factor error, 2 and 3 the E with the other axes in order.
constexpr std::size_t index_of(std::size_t axis, std::size_t which) { return axis * per_axis + which; }
/// The other axis of E number `which` (2 or 3).
constexpr std::size_t other_axis(std::size_t axis, std::size_t which) {
  const std::size_t first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
  return which == 2 ? first : second;
}

struct Calibration {
  std::vector<double> value;               ///< 12 [SI]
  std::vector<double> degrees_of_freedom;  ///< 12
  std::vector<ErrorLine> lines;            ///< of the 12
  std::vector<double> least, greatest;     ///< 12 [SI], of the regressor of each term in the test of the whole unit
  double temperature = 293.15;             ///< [K] at which it holds
  Findings findings;
};

/// All three channels of the unit, each by linear identification over the positions (and rates), turned into (3.4).
Calibration whole_of(Kind kind, const Evidence& whole);

/// Each channel by itself: accelerometers from four positions, at `temperature` where there are several; gyros from
/// rates. E is `assembly_sd` from zero. Given: temperature [K].
Calibration split_of(Kind kind, const Sorted& sorted, double temperature);

}  // namespace tumble::imu_channel_calibration
