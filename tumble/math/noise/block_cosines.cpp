#include "tumble/math/noise/block_cosines.hpp"

#include <cmath>
#include <cstddef>

#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

double weight(int radix, int order, int i) { return std::sqrt(2.0 / radix) * std::cos(pi * order * (i + 0.5) / radix); }

/// Mean of what is there; NaN if more than half is missing.
double mean_of_rest(const double* y, int p) {
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < p; ++i)
    if (!std::isnan(y[i])) {
      sum += y[i];
      ++count;
    }
  return 2 * count >= p ? sum / count : std::nan("");
}

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
[[gnu::always_inline]] inline ContrastSums take16(const Sixteen& cosines, std::span<const double> values,
                                                  double* means) {
  constexpr std::size_t p = widest_block;
  Lanes first[groups] = {}, second[groups] = {}, x[groups];
  ContrastSums sums;
  const double to_mean = std::sqrt(0.5 / p);
  for (std::size_t b = 0; b < values.size() / p; ++b) {
    const double* const y = values.data() + b * p;
    cosines.transform(y, x);
    const double sum = x[3][0];
    if (std::isnan(sum)) {
      means[b] = mean_of_rest(y, p);
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
[[gnu::target("avx2")]] ContrastSums take16_avx2(const Sixteen& cosines, std::span<const double> values,
                                                 double* means) {
  return take16(cosines, values, means);
}
#endif

ContrastSums take_sixteen(std::span<const double> values, double* means) {
  static const Sixteen cosines;
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return take16_avx2(cosines, values, means);
#endif
  return take16(cosines, values, means);
}

}  // namespace

void ContrastSums::add(const ContrastSums& more) {
  for (int k = 0; k < widest_block; ++k) {
    first[k] += more.first[k];
    second[k] += more.second[k];
  }
  count += more.count;
}

double ContrastSums::square(int radix) const {
  double sum = 0.0;
  for (int k = 1; k < radix; ++k) sum += second[k];
  return sum;
}

BlockCosines::BlockCosines(int radix) : radix_(radix) {
  for (int k = 0; k < radix; ++k)
    for (int i = 0; i < radix; ++i) weight_[i][k] = weight(radix, k, i);
}

ContrastSums BlockCosines::take(std::span<const double> values, double* means) const {
  static_assert(widest_block == 16);
  if (radix_ == widest_block) return take_sixteen(values, means);
  ContrastSums sums;
  const auto p = static_cast<std::size_t>(radix_);
  const double to_mean = std::sqrt(0.5 / static_cast<double>(p));
  for (std::size_t b = 0; b < values.size() / p; ++b) {
    const double* y = values.data() + b * p;
    double x[widest_block] = {};
    for (std::size_t i = 0; i < p; ++i)
      for (std::size_t k = 0; k < p; ++k) x[k] += weight_[i][k] * y[i];
    if (std::isnan(x[0])) {
      means[b] = mean_of_rest(y, radix_);
      continue;
    }
    means[b] = x[0] * to_mean;
    for (std::size_t k = 0; k < p; ++k) {
      sums.first[k] += x[k];
      sums.second[k] += x[k] * x[k];
    }
    ++sums.count;
  }
  return sums;
}

}  // namespace tumble
