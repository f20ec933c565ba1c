#pragma once

#include <cstdint>
#include <optional>

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

}  // namespace tumble::topics
