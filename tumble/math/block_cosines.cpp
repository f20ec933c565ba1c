#include "tumble/math/block_cosines.hpp"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace tumble {
namespace {

double weight(int radix, int order, int i) {
  return std::sqrt(2.0 / radix) * std::cos(std::numbers::pi * order * (i + 0.5) / radix);
}

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

/// Of 16 values: odd orders from differences of opposite values, even ones from their sums, twice.
struct Sixteen {
  Sixteen() {
    for (int i = 0; i < 8; ++i)
      for (int k = 0; k < 8; ++k) odd[i][k] = weight(16, 2 * k + 1, i);
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 4; ++k) {
        even[i][k] = weight(16, 4 * k + 2, i);
        even[i][4 + k] = weight(16, 4 * k, i);
      }
  }
  /// Order at each place of what `transform` gives.
  static int order(int place) {
    return place < 8 ? 2 * place + 1 : place < 12 ? 4 * (place - 8) + 2 : 4 * (place - 12);
  }

  [[gnu::always_inline]] inline void transform(const double* y, double* out) const {
    double e[8], o[8], folded[4][2];
    for (int i = 0; i < 8; ++i) {
      e[i] = y[i] + y[15 - i];
      o[i] = y[i] - y[15 - i];
    }
    for (int i = 0; i < 4; ++i) {
      folded[i][0] = e[i] - e[7 - i];
      folded[i][1] = e[i] + e[7 - i];
    }
    for (int k = 0; k < 16; ++k) out[k] = 0.0;
    for (int i = 0; i < 8; ++i)
      for (int k = 0; k < 8; ++k) out[k] += odd[i][k] * o[i];
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < 4; ++k) out[8 + k] += even[i][k] * folded[i][0];
      for (int k = 4; k < 8; ++k) out[8 + k] += even[i][k] * folded[i][1];
    }
  }

  alignas(64) double odd[8][8], even[4][8];
};

/// Operations and their order are fixed, and none is fused (see CMakeLists.txt): the processor does not matter.
[[gnu::always_inline]] inline ContrastSums take16(const Sixteen& cosines, std::span<const double> values,
                                                  double* means) {
  constexpr int p = 16;
  alignas(64) double first[p] = {}, second[p] = {}, x[p];
  ContrastSums sums;
  const double to_mean = std::sqrt(0.5 / p);
  for (std::size_t b = 0; b < values.size() / p; ++b) {
    const double* const y = values.data() + b * p;
    cosines.transform(y, x);
    if (std::isnan(x[12])) {
      means[b] = mean_of_rest(y, p);
      continue;
    }
    means[b] = x[12] * to_mean;
    for (int k = 0; k < p; ++k) first[k] += x[k];
    for (int k = 0; k < p; ++k) second[k] += x[k] * x[k];
    ++sums.count;
  }
  for (int k = 0; k < p; ++k) {
    sums.first[Sixteen::order(k)] = first[k];
    sums.second[Sixteen::order(k)] = second[k];
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
