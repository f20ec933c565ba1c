#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tumble/formats/format.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {

/// The --set values by what they speak of.
struct SortedSets {
  ReadOptions reading;                                        ///< rate, missing, columns, segment_column, unit.<column>
  std::vector<std::pair<std::string, std::string>> channels;  ///< channels.<role>
  std::vector<Given> settings, truth, rig, beside;
  std::optional<std::string> calibration;
};

/// `rate` is for reading; when `method_has_rate` it is a setting of the method as well. Throws Error::bad_input.
SortedSets sorted(const Sets& sets, bool method_has_rate);

/// "dtg.x[deg/h]". Throws Error::bad_input.
ChannelChoice parse_choice(const std::string& text);
/// "S1, S2[pulse]". Throws Error::bad_input.
std::vector<ChannelChoice> parse_choices(const std::string& text);
/// Their names, separated by commas.
std::string listed(const std::vector<ChannelChoice>& choices);

/// What was given, with what the command line says in place of the same key from the file.
std::vector<Given> overridden(std::vector<Given> from_file, const std::vector<Given>& from_command_line);

}  // namespace tumble
