#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tumble/core/read_options.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {

/// The --set values by what they speak of.
struct SortedSets {
  ReadOptions reading;  ///< rate, missing, columns, unit.<column> and the like: ReadOptions
  std::vector<std::pair<std::string, std::string>> channels;  ///< channels.<role>
  std::vector<Given> settings, truth, rig, beside;
  std::optional<std::string> calibration, prior;
  std::optional<std::string> serial, slot;  ///< instrument.serial, instrument.slot: which unit it is
};

/// `rate` is for reading, and among the settings too: for a method that has an option of that name. Throws
/// Error::bad_input.
SortedSets sorted(const Sets& sets);

/// The decimal mark called "comma" or "point". Throws Error::bad_input.
char parse_decimal(const std::string& text);
/// "dmy", "mdy" or "ymd". Throws Error::bad_input.
std::string parse_date_order(const std::string& text);
/// A number of lines. Throws Error::bad_input.
std::size_t parse_skip(const std::string& text);

/// "dtg.x[deg/h]". Throws Error::bad_input.
ChannelChoice parse_choice(const std::string& text);
/// "S1, S2[pulse]". Throws Error::bad_input.
std::vector<ChannelChoice> parse_choices(const std::string& text);
/// The names of the choices, separated by commas.
std::string listed(const std::vector<ChannelChoice>& choices);

/// Settings from a file, with those of the command line in place of the same keys.
std::vector<Given> overridden(std::vector<Given> from_file, const std::vector<Given>& from_command_line);

}  // namespace tumble
