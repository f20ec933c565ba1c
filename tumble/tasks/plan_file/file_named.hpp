#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tumble/core/tables/section.hpp"

namespace tumble::plan_file {

/// The file that a key of a plan names, from the folder of the plan on; none, with a problem of the key, where it may
/// not be opened.
std::optional<std::string> file_named(tables::Section& section, const char* key, const std::filesystem::path& folder);

}  // namespace tumble::plan_file
