#pragma once

#include <filesystem>

#include "tumble/core/plan.hpp"
#include "tumble/core/tables/document.hpp"
#include "tumble/core/tables/section.hpp"

namespace tumble::plan_file {

/// Entry of [[recording]] for its file, without `plan`; names are relative to `folder`. A fault becomes a problem of
/// the section.
RecordingEntry read_recording_entry(tables::Section& section, const std::filesystem::path& folder);

}  // namespace tumble::plan_file
