#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

#include "tumble/core/tables/section.hpp"
#include "tumble/station/station_file.hpp"

namespace tumble::station_file {

using tables::FileProblems;
using tables::Section;

/// A station while it is read.
struct Draft {
  Station station;
  FileProblems problems;
  std::string folder;  ///< of the file
};

/// The tables of the list at `key`; a problem where something else stands there.
std::vector<const toml::table*> tables_at(Section& section, const std::string& key, const std::string& heading);
bool flag(Section& section, const std::string& key);
/// The text at `key`; a problem where it is missing or empty.
std::string needed(Section& section, const std::string& key, const std::string& example);
/// The index of the device of that name; a problem, and absent, for an unknown name.
std::optional<std::size_t> device_at(Section& section, const std::string& key, const Station& station);
/// One of the words, by its index; a problem where another stands there.
std::optional<std::size_t> choice(Section& section, const std::string& key, const std::vector<std::string>& words);

void read_devices(Section& root, Draft& draft);
void read_instruments(Section& root, Draft& draft);
void read_interlocks(Section& root, Draft& draft);
void read_safe(Section& root, Draft& draft);
void read_equipment(Section& root, Draft& draft);
void read_power(Section& root, Draft& draft);

/// Whether this is a date as "2026-11-24".
bool is_date(const std::string& text);

}  // namespace tumble::station_file
