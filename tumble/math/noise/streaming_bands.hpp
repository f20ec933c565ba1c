#pragma once

#include <cstddef>
#include <deque>
#include <span>
#include <vector>

#include "tumble/math/noise/block_cosines.hpp"
#include "tumble/math/noise/noise_bands.hpp"

namespace tumble {

/// The contrasts of a rate record that arrives piece by piece or does not fit into memory: the bands that NoiseBands
/// has of the whole record, to rounding (1e-12), from about 1 MB for each factor of 16 in its length. The bounds
/// between the parts of equal length are those of the pieces that were summed, at most 1/512 of the record off.
class StreamingNoiseBands {
 public:
  /// The next samples [u]; NaN: missing. The bands do not depend on how the record is cut into calls.
  void push(std::span<const double> rate);

  /// Those of what has come so far. Throws as NoiseBands.
  NoiseBands bands() const;

  std::size_t samples() const { return samples_; }

 private:
  static constexpr std::size_t slice = 8192, most_parts = 1024;

  struct Scale {
    std::vector<double> kept;  ///< not yet in blocks: all values, until there are so many that blocks are the widest
    bool passed = false;       ///< ... as they are
    ScaleSums sums;
  };
  struct Part {
    std::size_t blocks = 0;
    double contrasts = 0.0, square = 0.0;
    void add(const Part& more);
  };

  void push(std::size_t index, std::span<const double> values);
  void take(std::size_t index, std::span<const double> blocks);
  void note(const Part& part);

  std::deque<Scale> scales_;
  std::vector<Part> parts_;
  std::size_t part_blocks_ = slice / widest_block;
  std::size_t samples_ = 0;
};

}  // namespace tumble
