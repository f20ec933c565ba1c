#pragma once

#include <cstddef>
#include <span>

#include "tumble/math/noise/noise_bands.hpp"

namespace tumble {

constexpr int widest_block = 16;
constexpr std::size_t most_values = 16384;  ///< of the slow part
/// From here on a scale has blocks of the widest: what they leave is still half of the most, or more.
constexpr std::size_t values_for_widest = widest_block * most_values / 2;

/// Sums over blocks of the contrasts, by their order, and of their squares.
struct ContrastSums {
  double first[widest_block] = {}, second[widest_block] = {};
  double count = 0.0;  ///< of blocks

  void add(const ContrastSums& more);
  /// Sum of the squares of all orders from 1 to radix - 1 [u^2].
  double square(int radix) const;
};

/// Cosine transform of blocks of `radix` values.
class BlockCosines {
 public:
  /// radix: 2 to 16
  explicit BlockCosines(int radix);

  /// Given     values  whole blocks [u]. NaN: missing
  /// Returned  sums over the blocks that are complete; means: one a block, of the rest where half or less is missing
  ContrastSums take(std::span<const double> values, double* means) const;

 private:
  int radix_;
  double weight_[widest_block][widest_block];
};

/// Adds the bands of one scale to `result`, from the sums over all its blocks. unit [samples] of a value.
void add_bands(const ContrastSums& whole, double unit, int radix, NoiseBands& result);

}  // namespace tumble
