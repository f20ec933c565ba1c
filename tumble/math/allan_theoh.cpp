#include "tumble/math/allan_theoh.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tumble {
namespace {

constexpr std::size_t most_ratios = 64;

/// 2 E(v)^2/var(v) at tau/T, of 1000 records of 300 and 300 of 1200 samples, which agree within their scatter (6 %).
constexpr std::array<double, 9> shares{0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75};
constexpr std::array<std::array<double, 9>, 3> simulated{{{17.2, 13.1, 11.4, 8.3, 6.1, 4.76, 3.28, 2.25, 1.90},
                                                          {9.8, 6.7, 5.3, 3.75, 2.75, 2.00, 1.50, 1.28, 1.22},
                                                          {8.1, 5.1, 3.75, 2.45, 1.78, 1.34, 1.07, 0.95, 0.94}}};

}  // namespace

double allan_over_theo1(std::span<const double> x) {
  const std::size_t count = x.size() / 30 >= 3 ? x.size() / 30 - 2 : 0;  // n + 1
  const std::size_t stride = (count + most_ratios - 1) / most_ratios;
  double sum = 0.0, used = 0.0;
  for (std::size_t i = 0; i < count; i += stride) {
    sum += difference_variance(x, 9 + 3 * i, 2, 1).value / theo1_variance(x, 12 + 4 * i).value;
    ++used;
  }
  return used > 0.0 && std::isfinite(sum) ? sum / used : 0.0;
}

MeanSquare theoh_variance(std::span<const double> x, double bias, std::size_t m) {
  if (x.empty()) return {};
  if (theoh_shortest_ratio * static_cast<double>(m) <= static_cast<double>(x.size() - 1))
    return difference_variance(x, m, 2, 1);
  if (m % 3 != 0 || !(bias > 0.0)) return {};
  const MeanSquare theo1 = theo1_variance(x, m / 3 * 4);
  return {bias * theo1.value, theo1.count};
}

double theo_bias_removed_edf(int alpha, double ratio) {
  if (alpha > 0) return 0.0;
  const auto& edf = simulated[static_cast<std::size_t>(std::min(-alpha, 2))];
  const double share = std::clamp(1.0 / ratio, shares.front(), shares.back());
  std::size_t i = 0;
  while (i + 2 < shares.size() && share > shares[i + 1]) ++i;
  const double part = std::log(share / shares[i]) / std::log(shares[i + 1] / shares[i]);
  return edf[i] * std::pow(edf[i + 1] / edf[i], part);
}

}  // namespace tumble
