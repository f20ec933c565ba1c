#pragma once

#include <cstdint>
#include <string>

#include "tumble/formats/format.hpp"
#include "tumble/formats/random_access.hpp"

namespace tumble::hdf5 {

Recording read(const std::string& path, const ReadOptions& options, const Progress& progress);
std::uintmax_t memory(const std::string& path, const ReadOptions& options);
void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress);
SampleReader samples(const std::string& path, const ReadOptions& options);
RecordingWriter writer(const std::string& path);

}  // namespace tumble::hdf5
