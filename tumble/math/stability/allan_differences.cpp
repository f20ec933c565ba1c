#include "tumble/math/stability/allan_differences.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include "tumble/math/parallel.hpp"
#include "tumble/math/stability/difference_kernels.hpp"
#include "tumble/math/stability/lag_sums.hpp"

namespace tumble {
namespace {

/// All terms of these factors, to their places: piece by piece, which serves all of them while the caches hold it.
void add_directly(std::span<const double> x, std::span<const std::size_t> factors, std::span<const std::size_t> places,
                  std::span<double> sums) {
  constexpr std::size_t piece = 32768;
  if (places.empty()) return;
  const std::size_t most = x.size() - 2 * factors[places.front()];  // terms
  std::vector<double> partial((most + piece - 1) / piece * places.size(), 0.0);
  parallel_pieces(most, piece, [&](std::size_t first, std::size_t last) {
    double* const here = partial.data() + first / piece * places.size();
    for (std::size_t k = 0; k < places.size(); ++k) {
      const std::size_t m = factors[places[k]], end = std::min(last, x.size() - 2 * m);
      if (first < end) here[k] = second_difference_squares(x.data() + first, m, end - first);
    }
  });
  for (std::size_t i = 0; i < partial.size(); ++i) sums[places[i % places.size()]] += partial[i];
}

/// Factors whose sum of second differences follows from sums over lags, and their doubles. Sums that serve one factor
/// alone are two for one, and no quicker.
std::vector<std::size_t> lags_of(std::size_t size, std::span<const std::size_t> factors) {
  const auto given = [&](std::size_t m) { return std::binary_search(factors.begin(), factors.end(), m); };
  std::vector<std::size_t> lags, doubles;
  for (const std::size_t m : factors) {
    if (!has_lag_sum(size, m) || !has_lag_sum(size, 2 * m)) continue;
    if (!given(2 * m) && (m % 2 != 0 || !given(m / 2))) continue;
    lags.push_back(m);
    doubles.push_back(2 * m);
  }
  std::vector<std::size_t> all;
  std::set_union(lags.begin(), lags.end(), doubles.begin(), doubles.end(), std::back_inserter(all));
  return all;
}

}  // namespace

double second_difference_squares(const double* x, std::size_t factor, std::size_t count) {
  return difference_kernels().second_differences(x, factor, count);
}

void add_second_differences(std::span<const double> x, std::span<const std::size_t> factors, std::span<double> sums) {
  constexpr std::size_t worth_sharing = 2048;
  // Of a sum over a lag. Measured: up to 2.3, and 4.3 of terms that are equal and so are rounded in one direction.
  constexpr double rounding = 16.0 * std::numeric_limits<double>::epsilon(), tolerance = 2e-10;  // 1e-10 of a deviation
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
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const LagSum *one = at(factors[i]), *two = at(2 * factors[i]);
    const double sum = one && two ? 2.0 * one->inner - two->all : 0.0;
    const bool exact = one && two && rounding * (2.0 * one->inner + two->all) <= tolerance * sum;
    if (exact)
      sums[i] += sum;
    else
      left.push_back(i);
  }
  add_directly(x, factors, left, sums);
}

std::vector<double> second_difference_sums(const Phase& phase, std::span<const std::size_t> factors) {
  std::vector<double> sums(factors.size(), 0.0);
  for (const auto& run : phase.runs)
    add_second_differences({phase.values.data() + run.first, run.points()}, factors, sums);
  return sums;
}

}  // namespace tumble
