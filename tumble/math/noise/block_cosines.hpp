#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "tumble/math/noise/noise_bands.hpp"

namespace tumble {

constexpr int widest_block = 16;
constexpr std::size_t most_values = 16384;  ///< of the slow part
/// From here on a scale has blocks of the widest: what they leave is still half of the most, or more.
constexpr std::size_t values_for_widest = widest_block * most_values / 2;

/// How many blocks have the same values missing. Bit i of a mask is set where value i is present.
class BlockPatterns {
 public:
  void add(unsigned mask, double blocks = 1.0);  ///< blocks [1]: their number
  void add(const BlockPatterns& more);
  bool empty() const { return few_.empty() && many_.empty(); }
  std::map<unsigned, double> counts() const;  ///< [blocks] by mask

  template <class State>
  void pass(State& state) {
    state(few_, many_);
  }

 private:
  std::vector<std::uint16_t> few_;  ///< one a block, until there are many
  std::vector<double> many_;        ///< by mask
};

/// Sums over blocks of the contrasts, by their order, and of their squares; over those that are incomplete, of the
/// values less the mean of those present.
struct ContrastSums {
  double first[widest_block] = {}, second[widest_block] = {};
  double count = 0.0;      ///< of complete blocks
  double contrasts = 0.0;  ///< of an order, independent: an incomplete block has k values of p and counts (k-1)/(p-1)
  /// Sums over incomplete blocks, by order: the contrast times the contrast of a ramp of 1 u a value with the same
  /// values missing, and the square of the latter.
  double with_ramp[widest_block] = {}, ramp_square[widest_block] = {};
  BlockPatterns patterns;  ///< of incomplete blocks that have half of their values or more

  void add(const ContrastSums& more);

  template <class State>
  void pass(State& state) {
    state(first, second, count, contrasts, with_ramp, ramp_square, patterns);
  }
};

/// Cosine transform of blocks of `radix` values.
class BlockCosines {
 public:
  /// radix: 2 to 16
  explicit BlockCosines(int radix);

  /// Given     values  whole blocks [u]. NaN: missing
  /// Returned  sums over the blocks that have half of their values or more; means: one a block, of the values present;
  ///           NaN for other blocks
  ContrastSums take(std::span<const double> values, double* means) const;

  std::size_t radix() const { return static_cast<std::size_t>(radix_); }

 private:
  void take_incomplete(const double* y, double& mean, ContrastSums& sums) const;

  int radix_;
  double weight_[widest_block][widest_block];
};

/// Sums over all blocks of a scale, and over 512 to 1024 equal groups of them (of a short record each by itself).
class ScaleSums {
 public:
  ScaleSums() = default;
  /// Sums of one part of a record. first: index of its first block; blocks: blocks of the whole record. Both define the
  /// groups.
  ScaleSums(std::size_t first, std::size_t blocks);

  /// Given     values  whole blocks [u]. NaN: missing
  /// Returned  their sums; means: one a block
  ContrastGroup take(const BlockCosines& cosines, std::span<const double> values, double* means);
  /// Adds the part that follows.
  void append(const ScaleSums& next);

  const ContrastSums& whole() const { return whole_; }
  const std::vector<ContrastGroup>& groups() const { return groups_; }
  std::size_t group_blocks() const { return group_blocks_; }                         ///< number of blocks of a group
  std::size_t last_blocks() const { return filled_ > 0 ? filled_ : group_blocks_; }  ///< ... of the last one

  template <class State>
  void pass(State& state) {
    state(whole_, groups_, group_blocks_, filled_);
  }

 private:
  ContrastSums whole_;
  std::vector<ContrastGroup> groups_;
  std::size_t group_blocks_ = 1, filled_ = 0;
};

/// Adds the bands of one scale to `result`, from the sums over all its blocks. unit [samples] of a value.
void add_bands(const ScaleSums& sums, double unit, int radix, NoiseBands& result);

}  // namespace tumble
