#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/formats/ros/stream.hpp"
#include "tumble/formats/topics/topic.hpp"

namespace tumble::ros {

/// Where a file could not be read, and how much it holds.
struct ScanReport {
  std::map<std::uint32_t, Count> counts;
  std::size_t damaged = 0;        ///< pieces
  std::uint64_t first_place = 0;  ///< [bytes]
  std::string first_reason;
};

/// Reads all pieces on all threads, and hands out what they hold of the streams in the order of the file, a few
/// stretches at a time: values in the units of the columns, and the stamps of both clocks.
/// Given: take, called from one thread in that order; progress, done [1].
ScanReport scan(const Log& log, const std::vector<Stream>& streams, const topics::Take& take, const Progress& progress);

}  // namespace tumble::ros
