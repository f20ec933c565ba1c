#pragma once

#include "tumble/core/read_options.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/formats/file/gathered.hpp"
#include "tumble/formats/mat/array.hpp"

namespace tumble::mat {

/// Channels, clocks and units from what a file holds. `path` for messages. Throws Error::bad_file with all that is
/// missing.
file::Gathered recording_of(Contents contents, const std::string& path, const ReadOptions& options);

}  // namespace tumble::mat
