#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tumble/formats/dataflash/scan.hpp"

namespace tumble::dataflash {

/// Messages of inertial samples that ArduPilot writes.
struct KnownMessage {
  std::string_view name;
  bool gyro, accelerometer;  ///< what they hold
  int instance;              ///< of the sensor where the messages have no field for it
};

/// Null for all others.
const KnownMessage* known_message(std::string_view name);

/// Names and unit of a field of a known message; false for a field that is no sample. `instance`: of the sensor, from
/// 0.
bool describe(int instance, topics::Column& column);

/// Number of the sensor, from 0.
int instance_of(const Stream& stream, std::string_view name);

/// Streams that are read where the user names none: those of the first gyro and of the first accelerometer with the
/// most messages. Indices among `streams`.
std::vector<std::size_t> preferred(const Scan& scan, const std::vector<std::size_t>& streams);

/// The parameters of this sensor by which ArduPilot corrects its samples, where they are not neutral: "INS_GYROFFS_X".
std::vector<std::string> corrections(const Scan& scan, const KnownMessage& message, int instance);

}  // namespace tumble::dataflash
