#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tumble/formats/format.hpp"
#include "tumble/formats/topics/topic.hpp"

namespace tumble::topics {

/// The log in memory. An infinite sample is read as missing, and a finding says so. A stated `rate` [Hz] is taken for
/// each topic whose stamps it fits. Throws Error::bad_file.
Recording read(const Log& log, std::optional<double> rate, const Progress& progress);
/// Bytes of all samples and stamps.
std::uintmax_t memory(const Log& log);
/// Blocks of about `samples` samples [1] of the channel with the most. Throws Error::bad_file.
void stream(const Log& log, std::optional<double> rate, std::size_t samples, const BlockSink& sink,
            const Progress& progress);

/// Looks through a file, and chooses what is read of it. With `checksum` another thread works out that of the file from
/// now on, and the frame of the log has it. Throws Error::bad_file.
using Open = Log (*)(const std::string& path, const ReadOptions& options, bool checksum);

/// The members `read`, `memory` and `stream` of a Format whose files are opened by `open`.
template <Open open>
Recording read_file(const std::string& path, const ReadOptions& options, const Progress& progress) {
  return read(open(path, options, true), options.rate, progress);
}
template <Open open>
std::uintmax_t memory_of_file(const std::string& path, const ReadOptions& options) {
  return memory(open(path, options, false));
}
template <Open open>
void stream_file(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
                 const Progress& progress) {
  stream(open(path, options, false), options.rate, samples, sink, progress);
}

}  // namespace tumble::topics
