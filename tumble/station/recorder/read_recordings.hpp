#pragma once

#include <string>
#include <vector>

#include "tumble/station/recorder/store_file.hpp"
#include "tumble/station/recorder_read.hpp"

namespace tumble::recorder {

/// read_store() from a store that is open. `path`: for messages. Throws Refusal too.
std::vector<StoreRecording> read_recordings(const StoreFile& store, const std::string& path, const Progress& progress);

}  // namespace tumble::recorder
