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
/// between the 16 parts of equal length are at most 1/512 of the record off.
///
/// Parts of a record whose length is known can be worked through apart, at the same time, and joined: the result is
/// that of the whole, to rounding. A part may begin at any sample. What it holds does not grow with its length.
class StreamingNoiseBands {
 public:
  StreamingNoiseBands() = default;
  /// A part. Given: index in the whole record of its first sample, and the length of the whole [samples].
  StreamingNoiseBands(std::size_t start, std::size_t total);

  /// The next samples [u]; NaN: missing. The bands do not depend on how the record is cut into calls.
  void push(std::span<const double> rate);

  /// Joins the part that follows. Throws Error::bad_input where it does not: of another record, or other samples
  /// between.
  void append(const StreamingNoiseBands& next);

  /// Bands of the samples pushed so far. Throws as NoiseBands.
  NoiseBands bands() const;

  std::size_t samples() const { return samples_; }

  template <class State>
  void pass(State& state) {
    state(scales_, start_, total_, samples_);
  }

 private:
  struct Scale {
    std::vector<double> lead;   ///< of a part: values before its first block, which lie in one of the part before
    std::size_t lead_size = 0;  ///< number of values that the lead has when it is complete
    std::vector<double> kept;   ///< not yet in blocks: all values, until there are so many that blocks are the widest
    bool passed = false;        ///< ... as they are
    ScaleSums sums;

    template <class State>
    void pass(State& state) {
      state(lead, lead_size, kept, passed, sums);
    }
  };

  void push(std::size_t index, std::span<const double> values);
  void take(std::size_t index, std::span<const double> blocks);
  void add_parts(NoiseBands& result) const;

  std::deque<Scale> scales_;
  std::size_t start_ = 0, total_ = 0;  ///< of a part; total 0: not one
  std::size_t samples_ = 0;
};

}  // namespace tumble
