#pragma once

#include <string>

#include "tumble/formats/format.hpp"

namespace tumble::frames {

/// Reads a recording, while another thread computes the checksum.
Recording read(const std::string& path, const ReadOptions& options, const Progress& progress);
/// Twice through the file: for the clock and what is wrong, and for the samples.
void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress);
/// [byte] by the share of samples in the first bytes.
std::uintmax_t memory(const std::string& path, const ReadOptions& options);

}  // namespace tumble::frames
