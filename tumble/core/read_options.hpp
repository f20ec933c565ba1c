#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tumble/units/unit.hpp"

namespace tumble {

/// Facts that a file does not state itself.
struct ReadOptions {
  std::optional<double> rate;         ///< [Hz] where the file has no time
  std::map<std::string, Unit> units;  ///< for columns without a unit, by column name
  std::vector<std::string> only;      ///< channels wanted; empty: all
  std::string missing;                ///< a word that means a missing sample, as a blank cell does
  /// name[unit] of each column of a text table, where it has no header line or in place of it; "-": not to be read
  std::vector<std::string> columns = {};
  std::string segment_column = {};  ///< of a text table: holds the label of the segment that each sample belongs to
  std::vector<std::string> topics = {};  ///< of a log with several streams: those wanted; empty: as the format chooses
  /// Declaration of the frames of a file of raw bytes, by name or file, and its variants: "kvh_1775:gyro_rate"
  std::string frames = {};
  char decimal = '\0';        ///< of a text table: the decimal mark, '.' or ','; 0: as the samples show it
  std::string time = {};      ///< of a text table: the column of the clock; "-": none; empty: by its name
  std::string date = {};      ///< of a text table: order in a date, "ymd", "dmy" or "mdy"; empty: by the samples
  std::string encoding = {};  ///< of a text table: "gb18030", "windows-1252"; empty: by its bytes
  std::size_t skip = 0;       ///< of a text table: lines before the header, or before the samples
};

}  // namespace tumble
