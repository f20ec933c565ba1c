#pragma once

#include <map>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/reduce/imu/sensors.hpp"

/// Which recordings are of the whole unit and which of a channel alone.
namespace tumble::imu_channel_calibration {

using imu::Kind;
using imu::kinds;
using imu::letters;
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

}  // namespace tumble::imu_channel_calibration
