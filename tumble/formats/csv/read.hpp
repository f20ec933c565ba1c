#pragma once

#include <string>

#include "tumble/formats/format.hpp"

namespace tumble::csv {

/// Without origin.checksum, on the calling thread alone.
Recording read_table(const std::string& path, const ReadOptions& options, const Progress& progress);
/// Reads a recording, while another thread computes the checksum.
Recording read(const std::string& path, const ReadOptions& options, const Progress& progress);
void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress);
RecordingWriter writer(const std::string& path);

}  // namespace tumble::csv
