#pragma once

#include <cstdint>

#include "tumble/formats/format.hpp"
#include "tumble/formats/ros/log.hpp"

namespace tumble::ros {

/// The topics wanted as a recording: what the members of Format of these names do, once the file has been opened.
Recording read(Log log, const ReadOptions& options, const Progress& progress);
std::uintmax_t memory(Log log, const ReadOptions& options);
void stream(Log log, const ReadOptions& options, std::size_t samples, const BlockSink& sink, const Progress& progress);

}  // namespace tumble::ros
