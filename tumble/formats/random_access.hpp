#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "tumble/core/read_options.hpp"

namespace tumble {

/// Appends `count` samples [SI] of channel number `channel` from sample `first` on to `to`. Channels are numbered as in
/// the recording. Several threads may call it. Throws Error::bad_file.
using SampleReader =
    std::function<void(std::size_t channel, std::size_t first, std::size_t count, std::vector<double>& to)>;

/// Samples from any place of a recording, whose file stays open; empty where its format can be read only from the
/// beginning. Throws Error::bad_file.
SampleReader sample_reader(const std::string& path, const ReadOptions& options);

}  // namespace tumble
