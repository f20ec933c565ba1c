#pragma once

#include <limits>
#include <string>

#include "tumble/core/progress.hpp"
#include "tumble/core/read_options.hpp"

namespace tumble {

/// A span of time [s] on the clock of a recording, both ends included.
struct TimeSpan {
  double from = -std::numeric_limits<double>::infinity(), to = std::numeric_limits<double>::infinity();
};

/// Throws Error::bad_input for each channel of `options.only` that the recording does not have, with those that it has.
void require_channels(const std::string& path, ReadOptions options);

/// A part of a recording in a file of its own, block after block: the samples of the span, of the channels that
/// `options.only` names (empty: all), and the marks of the segments that reach into it.
/// Throws Error::bad_data where no channel has a sample in it; else as convert().
void cut(const std::string& from, const std::string& to, const ReadOptions& options, const TimeSpan& span,
         const Progress& progress);

}  // namespace tumble
