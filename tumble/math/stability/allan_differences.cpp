#include "tumble/math/stability/allan_differences.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <limits>
#include <numeric>

#include "tumble/math/parallel.hpp"
#include "tumble/math/stability/lag_sums.hpp"

namespace tumble {
namespace {

/// sum_{n<count} ((x_n - x_{n+m}) + (x_{n+2m} - x_{n+m}))^2: differences of values near each other are exact, which the
/// sum of the outer two is not. Lanes and order of addition are fixed.
[[gnu::always_inline]] inline double sum_in_lanes(const double* x, std::size_t m, std::size_t count) {
  using Lanes = double __attribute__((vector_size(32)));
  constexpr std::size_t width = 4;
  Lanes squares[2] = {};
  std::size_t n = 0;
  for (; n + 2 * width <= count; n += 2 * width) {
#pragma GCC unroll 2
    for (std::size_t k = 0; k < 2; ++k) {
      const double* const p = x + n + k * width;
      Lanes first, middle, last;
      std::memcpy(&first, p, sizeof first);
      std::memcpy(&middle, p + m, sizeof middle);
      std::memcpy(&last, p + 2 * m, sizeof last);
      const Lanes z = (first - middle) + (last - middle);
      squares[k] += z * z;
    }
  }
  const Lanes both = squares[0] + squares[1];
  double sum = (both[0] + both[1]) + (both[2] + both[3]);
  for (; n < count; ++n) {
    const double z = (x[n] - x[n + m]) + (x[n + 2 * m] - x[n + m]);
    sum += z * z;
  }
  return sum;
}

#ifdef __x86_64__
[[gnu::target("avx2")]] double sum_avx2(const double* x, std::size_t m, std::size_t count) {
  return sum_in_lanes(x, m, count);
}
#endif

/// All terms of one factor.
double sum_directly(std::span<const double> x, std::size_t factor) {
  constexpr std::size_t piece = 65536;
  const std::size_t terms = x.size() - 2 * factor;
  std::vector<double> partial((terms + piece - 1) / piece, 0.0);
  parallel_pieces(terms, piece, [&](std::size_t first, std::size_t last) {
    partial[first / piece] = second_difference_squares(x.data() + first, factor, last - first);
  });
  return std::accumulate(partial.begin(), partial.end(), 0.0);
}

/// Factors whose sum of second differences follows from sums over lags, and their doubles.
std::vector<std::size_t> lags_of(std::size_t size, std::span<const std::size_t> factors) {
  std::vector<std::size_t> lags, doubles;
  for (const std::size_t m : factors) {
    if (!has_lag_sum(size, m) || !has_lag_sum(size, 2 * m)) continue;
    lags.push_back(m);
    doubles.push_back(2 * m);
  }
  std::vector<std::size_t> all;
  std::set_union(lags.begin(), lags.end(), doubles.begin(), doubles.end(), std::back_inserter(all));
  return all;
}

}  // namespace

double second_difference_squares(const double* x, std::size_t factor, std::size_t count) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return sum_avx2(x, factor, count);
#endif
  return sum_in_lanes(x, factor, count);
}

void add_second_differences(std::span<const double> x, std::span<const std::size_t> factors, std::span<double> sums) {
  constexpr std::size_t worth_sharing = 2048;
  constexpr double rounding = 4.0 * std::numeric_limits<double>::epsilon();  // of a sum over a lag; measured: up to 2.3
  const auto beyond = std::find_if(factors.begin(), factors.end(), [&](std::size_t m) { return 2 * m >= x.size(); });
  factors = factors.first(static_cast<std::size_t>(beyond - factors.begin()));
  if (x.size() < worth_sharing) {
    for (std::size_t i = 0; i < factors.size(); ++i)
      sums[i] += second_difference_squares(x.data(), factors[i], x.size() - 2 * factors[i]);
    return;
  }
  const auto lags = lags_of(x.size(), factors);
  const auto by_lag = lag_sums(x, lags);
  const auto at = [&](std::size_t lag) {
    const auto found = std::lower_bound(lags.begin(), lags.end(), lag);
    return found != lags.end() && *found == lag ? &by_lag[static_cast<std::size_t>(found - lags.begin())] : nullptr;
  };
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const LagSum *one = at(factors[i]), *two = at(2 * factors[i]);
    const double sum = one && two ? 2.0 * one->inner - two->all : 0.0;
    const bool exact = one && two && rounding * (2.0 * one->inner + two->all) <= 1e-10 * sum;
    sums[i] += exact ? sum : sum_directly(x, factors[i]);
  }
}

std::vector<double> second_difference_sums(const Phase& phase, std::span<const std::size_t> factors) {
  std::vector<double> sums(factors.size(), 0.0);
  for (const auto& run : phase.runs)
    add_second_differences({phase.values.data() + run.first, run.points()}, factors, sums);
  return sums;
}

}  // namespace tumble
