#include "tumble/math/noise/block_cosines.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

double weight(int radix, int order, int i) { return std::sqrt(2.0 / radix) * std::cos(pi * order * (i + 0.5) / radix); }

using Lanes = double __attribute__((vector_size(32)));

constexpr std::size_t width = 4, groups = widest_block / width;

/// Of 16 values: odd orders from differences of opposite values, even ones from their sums, twice.
struct Sixteen {
  Sixteen() {
    for (int i = 0; i < 8; ++i)
      for (int k = 0; k < 8; ++k) odd[i][k / 4][k % 4] = weight(16, 2 * k + 1, i);
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 4; ++k) {
        even[i][0][k] = weight(16, 4 * k + 2, i);
        even[i][1][k] = weight(16, 4 * k, i);
      }
  }
  /// Order at each place of what `transform` gives.
  static int order(int place) {
    return place < 8 ? 2 * place + 1 : place < 12 ? 4 * (place - 8) + 2 : 4 * (place - 12);
  }

  [[gnu::always_inline]] inline void transform(const double* y, Lanes (&out)[groups]) const {
    double sums[8];
    for (Lanes& lanes : out) lanes = Lanes{};
#pragma GCC unroll 8
    for (int i = 0; i < 8; ++i) {
      sums[i] = y[i] + y[15 - i];
      const double difference = y[i] - y[15 - i];
      out[0] += odd[i][0] * difference;
      out[1] += odd[i][1] * difference;
    }
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) {
      out[2] += even[i][0] * (sums[i] - sums[7 - i]);
      out[3] += even[i][1] * (sums[i] + sums[7 - i]);
    }
  }

  Lanes odd[8][2], even[4][2];
};

/// Operations and their order are fixed, and none is fused (see CMakeLists.txt): the processor does not matter.
[[gnu::always_inline]] inline ContrastSums take16(const Sixteen& cosines, std::span<const double> values, double* means,
                                                  std::vector<std::size_t>& incomplete) {
  constexpr std::size_t p = widest_block;
  Lanes first[groups] = {}, second[groups] = {}, x[groups];
  ContrastSums sums;
  const double to_mean = std::sqrt(0.5 / p);
  for (std::size_t b = 0; b < values.size() / p; ++b) {
    const double* const y = values.data() + b * p;
    cosines.transform(y, x);
    const double sum = x[3][0];
    if (std::isnan(sum)) {
      incomplete.push_back(b);
      continue;
    }
    means[b] = sum * to_mean;
#pragma GCC unroll 4
    for (std::size_t k = 0; k < groups; ++k) {
      first[k] += x[k];
      second[k] += x[k] * x[k];
    }
    ++sums.count;
  }
  for (std::size_t k = 0; k < p; ++k) {
    const int order = Sixteen::order(static_cast<int>(k));
    sums.first[order] = first[k / width][k % width];
    sums.second[order] = second[k / width][k % width];
  }
  return sums;
}

#ifdef __x86_64__
[[gnu::target("avx2")]] ContrastSums take16_avx2(const Sixteen& cosines, std::span<const double> values, double* means,
                                                 std::vector<std::size_t>& incomplete) {
  return take16(cosines, values, means, incomplete);
}
#endif

ContrastSums take_sixteen(std::span<const double> values, double* means, std::vector<std::size_t>& incomplete) {
  static const Sixteen cosines;
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return take16_avx2(cosines, values, means, incomplete);
#endif
  return take16(cosines, values, means, incomplete);
}

}  // namespace

void BlockPatterns::add(unsigned mask, double blocks) {
  constexpr std::size_t most_few = 4096;
  if (many_.empty() && blocks == 1.0 && few_.size() < most_few) {
    few_.push_back(static_cast<std::uint16_t>(mask));
    return;
  }
  if (many_.empty()) many_.assign(std::size_t{1} << widest_block, 0.0);
  for (const std::uint16_t one : few_) many_[one] += 1.0;
  few_.clear();
  many_[mask] += blocks;
}

void BlockPatterns::add(const BlockPatterns& more) {
  for (const std::uint16_t mask : more.few_) add(mask);
  for (unsigned mask = 0; mask < more.many_.size(); ++mask)
    if (more.many_[mask] > 0.0) add(mask, more.many_[mask]);
}

std::map<unsigned, double> BlockPatterns::counts() const {
  std::map<unsigned, double> counts;
  for (const std::uint16_t mask : few_) counts[mask] += 1.0;
  for (unsigned mask = 0; mask < many_.size(); ++mask)
    if (many_[mask] > 0.0) counts[mask] += many_[mask];
  return counts;
}

void ContrastSums::add(const ContrastSums& more) {
  for (int k = 0; k < widest_block; ++k) {
    first[k] += more.first[k];
    second[k] += more.second[k];
    with_ramp[k] += more.with_ramp[k];
    ramp_square[k] += more.ramp_square[k];
  }
  count += more.count;
  contrasts += more.contrasts;
  patterns.add(more.patterns);
}

BlockCosines::BlockCosines(int radix) : radix_(radix) {
  for (int k = 0; k < radix; ++k)
    for (int i = 0; i < radix; ++i) weight_[i][k] = weight(radix, k, i);
}

ContrastSums BlockCosines::take(std::span<const double> values, double* means) const {
  static_assert(widest_block == 16);
  const auto p = static_cast<std::size_t>(radix_);
  if (radix_ == widest_block) {
    std::vector<std::size_t> incomplete;
    ContrastSums sums = take_sixteen(values, means, incomplete);
    for (const std::size_t b : incomplete) take_incomplete(values.data() + b * p, means[b], sums);
    sums.contrasts += sums.count;
    return sums;
  }
  ContrastSums sums;
  const double to_mean = std::sqrt(0.5 / static_cast<double>(p));
  for (std::size_t b = 0; b < values.size() / p; ++b) {
    const double* y = values.data() + b * p;
    double x[widest_block] = {};
    for (std::size_t i = 0; i < p; ++i)
      for (std::size_t k = 0; k < p; ++k) x[k] += weight_[i][k] * y[i];
    if (std::isnan(x[0])) {
      take_incomplete(y, means[b], sums);
      continue;
    }
    means[b] = x[0] * to_mean;
    for (std::size_t k = 0; k < p; ++k) {
      sums.first[k] += x[k];
      sums.second[k] += x[k] * x[k];
    }
    ++sums.count;
  }
  sums.contrasts += sums.count;
  return sums;
}

namespace {

constexpr std::size_t most_groups = 1024;

}  // namespace

void ContrastGroup::add(const ContrastGroup& more) {
  contrasts += more.contrasts;
  for (std::size_t k = 0; k < square.size(); ++k) square[k] += more.square[k];
}

ScaleSums::ScaleSums(std::size_t first, std::size_t blocks) {
  while (group_blocks_ * most_groups < blocks) group_blocks_ *= 2;
  filled_ = first % group_blocks_;
}

ContrastGroup ScaleSums::take(const BlockCosines& cosines, std::span<const double> values, double* means) {
  const std::size_t p = cosines.radix();
  ContrastGroup all{0.0, {}};
  while (!values.empty()) {
    if (filled_ == 0 && groups_.size() == most_groups) {
      for (std::size_t i = 0; i < most_groups / 2; ++i) {
        groups_[i] = groups_[2 * i];
        groups_[i].add(groups_[2 * i + 1]);
      }
      groups_.resize(most_groups / 2);
      group_blocks_ *= 2;
    }
    if (filled_ == 0 || groups_.empty()) groups_.push_back({0.0, {}});
    const std::size_t blocks = std::min(group_blocks_ - filled_, values.size() / p);
    const ContrastSums sums = cosines.take(values.first(blocks * p), means);
    ContrastGroup some{sums.contrasts, {}};
    for (std::size_t k = 0; k < p; ++k) some.square[k] = sums.second[k];
    groups_.back().add(some);
    all.add(some);
    filled_ = (filled_ + blocks) % group_blocks_;
    whole_.add(sums);
    values = values.subspan(blocks * p);
    means += blocks;
  }
  return all;
}

void ScaleSums::append(const ScaleSums& next) {
  if (next.groups_.empty()) return;
  whole_.add(next.whole_);
  auto more = next.groups_.begin();
  if (filled_ > 0 && !groups_.empty()) groups_.back().add(*more++);
  groups_.insert(groups_.end(), more, next.groups_.end());
  filled_ = next.filled_;
}

/// First sums of an incomplete block are not added: the ramp's own contrasts differ from block to block.
void BlockCosines::take_incomplete(const double* y, double& mean, ContrastSums& sums) const {
  const auto p = static_cast<std::size_t>(radix_);
  double sum = 0.0, middle = 0.0, present = 0.0;
  unsigned mask = 0;
  for (std::size_t i = 0; i < p; ++i) {
    if (std::isnan(y[i])) continue;
    sum += y[i];
    middle += static_cast<double>(i);
    ++present;
    mask |= 1u << i;
  }
  mean = std::nan("");
  if (2.0 * present < static_cast<double>(p)) return;
  mean = sum / present;
  middle /= present;
  double x[widest_block] = {}, ramp[widest_block] = {};
  for (std::size_t i = 0; i < p; ++i) {
    if (((mask >> i) & 1u) == 0) continue;
    for (std::size_t k = 1; k < p; ++k) {
      x[k] += weight_[i][k] * (y[i] - mean);
      ramp[k] += weight_[i][k] * (static_cast<double>(i) - middle);
    }
  }
  for (std::size_t k = 1; k < p; ++k) {
    sums.second[k] += x[k] * x[k];
    sums.with_ramp[k] += x[k] * ramp[k];
    sums.ramp_square[k] += ramp[k] * ramp[k];
  }
  sums.contrasts += (present - 1.0) / static_cast<double>(radix_ - 1);
  sums.patterns.add(mask);
}

}  // namespace tumble
