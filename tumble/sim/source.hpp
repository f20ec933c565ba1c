#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "tumble/core/channel.hpp"

namespace tumble {

/// Where the next samples of some channels go, a span each, all of one length.
using Samples = std::vector<std::span<double>>;

/// Channels of one power-up that are made together, sample after sample. They are made in portions that begin at whole
/// multiples of `portion`, whatever lengths are asked for: no time is rounded in another way, so the bytes are the
/// same.
class Source {
 public:
  /// Fills one portion that begins at sample `first`; called in order.
  using Make = std::function<void(std::size_t first, const Samples& out)>;

  /// channels  without values; their timelines begin at the power-up
  /// total     samples of the power-up
  Source(std::vector<Channel> channels, std::size_t total, std::size_t portion, Make make);

  const std::vector<Channel>& channels() const { return channels_; }
  /// The next samples of every channel; no more than there are.
  void next(Samples out);

 private:
  std::vector<Channel> channels_;
  std::size_t total_, portion_;
  Make make_;
  std::size_t made_ = 0;                    ///< samples that have been made
  std::size_t kept_ = 0;                    ///< of these, the last ones that nobody has asked for yet
  std::vector<std::vector<double>> store_;  ///< the portion they belong to
};

}  // namespace tumble
