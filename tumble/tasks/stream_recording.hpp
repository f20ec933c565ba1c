#pragma once

#include <string>

#include "tumble/formats/format.hpp"

namespace tumble::tasks {

/// Hands a file of any format to `sink` in blocks of about `samples` samples a channel. Throws Error::bad_file.
void stream_recording(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
                      const Progress& progress);

}  // namespace tumble::tasks
