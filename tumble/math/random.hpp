#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace tumble {

/// A counter-based stream of random numbers (Philox4x32-10: Salmon et al., SC11, 2011). The n-th number depends on the
/// seed, the stream's names and n alone, so that any thread may make any part and the bytes stay the same.
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed) : key_(seed) {}

  /// An independent stream: one for each run, channel and noise term. Same name, same stream.
  RandomStream split(std::string_view name) const;
  RandomStream split(std::uint64_t number) const;

  /// Standard normal numbers [1] first, first + 1, ... into `out`.
  void normal(std::uint64_t first, std::span<double> out) const;
  double normal(std::uint64_t index) const;
  /// Uniform in (0, 1) [1].
  double uniform(std::uint64_t index) const;

 private:
  std::uint64_t key_;
};

}  // namespace tumble
