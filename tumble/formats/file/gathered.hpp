#pragma once

#include <memory>
#include <vector>

#include "tumble/formats/file/series.hpp"
#include "tumble/formats/format.hpp"

namespace tumble::file {

/// The samples of a channel, and where they are uneven their stamps.
struct Source {
  std::shared_ptr<Series> values;        ///< in the unit of the channel
  std::shared_ptr<const Series> stamps;  ///< null: even, the timeline of the channel is complete
  double second = 1.0, begin = 0.0;      ///< [s] of a stamp t: t * second + begin
  bool in_si = false;                    ///< the values are
};

/// Samples gathered by a reader that finds channel after channel, or no whole channel at one time: all samples, in
/// memory or in a spool. An infinite value becomes NaN.
struct Gathered {
  Recording frame;              ///< everything but the samples
  std::vector<Source> sources;  ///< by channel
};

/// The samples as a recording in memory. Channels that share their stamps there share them here. Throws
/// Error::bad_file.
Recording in_memory(Gathered gathered);
/// The samples in blocks, see stream_recording(). Throws Error::bad_file.
void hand_out(const Gathered& gathered, std::size_t samples, const BlockSink& sink, const Progress& progress);

}  // namespace tumble::file
