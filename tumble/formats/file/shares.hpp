#pragma once

#include <algorithm>
#include <cstddef>

namespace tumble::file {

/// How channels of different lengths are handed out in blocks: each in equal shares, so that a block holds about one
/// stretch of time.
class Shares {
 public:
  /// Blocks of about `samples` > 0 samples [1] of the longest channel.
  Shares(std::size_t longest, std::size_t samples) : blocks_(longest == 0 ? 1 : (longest - 1) / samples + 1) {}

  std::size_t blocks() const { return blocks_; }
  /// The first sample of block `index`, of a channel of `count` samples; of index blocks(), its end.
  std::size_t first(std::size_t count, std::size_t index) const {
    return count / blocks_ * index + count % blocks_ * index / blocks_;
  }

 private:
  std::size_t blocks_;
};

}  // namespace tumble::file
