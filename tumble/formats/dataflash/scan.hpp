#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tumble/formats/dataflash/messages.hpp"

namespace tumble::dataflash {

/// Messages of one id, or of one instance of it.
struct Stream {
  std::string name;  ///< "IMU:1", or "IMU2" where the messages have no instance
  std::uint8_t id = 0;
  int instance = -1;  ///< -1: the messages have none
  std::size_t messages = 0;
  std::optional<double> first;  ///< [s] of the first message, on the clock of the autopilot
};

/// Units of the fields of one id, by FMTU, a character for each.
struct FieldUnits {
  std::string units, multipliers;
};

/// Result of a pass through the file.
struct Scan {
  Descriptions descriptions;
  std::array<FieldUnits, 256> field_units;
  std::map<char, std::string> units;   ///< by the character of FMTU
  std::map<char, double> multipliers;  ///< likewise
  std::vector<Stream> streams;         ///< in the order of ids and instances
  std::map<std::string, double> parameters;
  std::string firmware;
  std::optional<std::int64_t> started;  ///< [ns] since 1970-01-01 UTC where that clock is 0, as a GPS receiver says
  double rejected = 0.0;                ///< messages that the logger could not write
  Damage damage;

  /// The field that numbers the instances, or null.
  const Field* instance_field(std::uint8_t id) const;
};

/// Throws Error::bad_file.
Scan scan(const std::string& path);

}  // namespace tumble::dataflash
