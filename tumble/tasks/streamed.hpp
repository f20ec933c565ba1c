#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/instant.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {

/// A recording too large for memory, for a method that takes it block after block.
struct Streamed {
  StreamedEvidence evidence;
  std::string file;
  std::uintmax_t bytes = 0;                 ///< of its samples
  std::shared_ptr<const Recording> header;  ///< everything but the samples, once the first block was handed out
  std::shared_ptr<const Extent> extent;     ///< of all blocks
  std::function<std::string()> checksum;    ///< see Origin
};

/// Empty where gather() is to read all: the samples take up to `memory` bytes, the method needs them all at once, or
/// there are several recordings. Role and unit are checked, as gather() does, at the first block.
std::optional<Streamed> open_stream(const Plan& plan, const std::vector<std::string>& recordings, std::uintmax_t memory,
                                    const Progress& progress);

}  // namespace tumble
