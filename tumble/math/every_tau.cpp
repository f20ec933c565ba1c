#include "tumble/math/every_tau.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tumble/math/allan_differences.hpp"
#include "tumble/math/allan_phase.hpp"
#include "tumble/math/lagged_products.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double tolerance = 1e-10;
constexpr double rounding_of_squares = 16.0 * std::numeric_limits<double>::epsilon();  // of a sum, over sum x^2
constexpr std::size_t few = 64;         // factors that are as quickly summed directly
constexpr double direct_share = 512.0;  // and so many at most, each over the whole record

/// Sums of z^2 at m = 1 ... longest and what rounding may do to them.
struct Sums {
  std::vector<double> values;
  double error = 0.0;     ///< of each sum
  double of_phase = 0.0;  ///< of each phase value: 4 sd of its share in a sum S are 6 sqrt(S) times this

  double error_of(double sum) const { return error + 6.0 * of_phase * std::sqrt(sum); }
};

std::vector<double> running_sums(std::span<const double> x, bool squares) {
  std::vector<double> sums(x.size() + 1, 0.0);
  long double sum = 0.0L;
  for (std::size_t n = 0; n < x.size(); ++n) {
    sum += squares ? static_cast<long double>(x[n]) * x[n] : static_cast<long double>(x[n]);
    sums[n + 1] = static_cast<double>(sum);
  }
  return sums;
}

/// The sums of a piece of phase of N points over all n with n + 2m < N, m = 1 ... longest.
Sums sums_of_piece(std::span<const double> phase, std::size_t longest, bool threads) {
  std::vector<double> x(phase.begin(), phase.end());
  double largest = 0.0;
  for (double& value : x) largest = std::max(largest, std::abs(value -= phase[0]));
  const double curvature = remove_quadratic(x);
  const auto products = lagged_products(x, longest, threads);
  const auto sum = running_sums(x, false), square = running_sums(x, true);
  const std::size_t size = x.size();
  Sums result{std::vector<double>(longest), rounding_of_squares * square.back(),
              std::numeric_limits<double>::epsilon() * largest};
  for (std::size_t m = 1; m <= longest; ++m) {
    const double squares = square[size - 2 * m] + 4.0 * (square[size - m] - square[m]) + (square[size] - square[2 * m]);
    const double lagged =
        2.0 * products.whole[2 * m] - 8.0 * products.whole[m] + 4.0 * (products.leading[m] + products.trailing[m]);
    const double differences = sum[size - 2 * m] - 2.0 * (sum[size - m] - sum[m]) + (sum[size] - sum[2 * m]);
    const double constant = 2.0 * curvature * static_cast<double>(m) * static_cast<double>(m);
    result.values[m - 1] =
        (squares + lagged) + constant * (2.0 * differences + constant * static_cast<double>(size - 2 * m));
  }
  return result;
}

/// The sums of the whole from pieces that overlap: terms of a piece less those within its overlap with the next.
Sums sums_in_pieces(std::span<const double> phase, std::size_t longest) {
  const std::size_t advance = 8 * longest, overlap = 2 * longest;
  const std::size_t pieces = (phase.size() - overlap + advance - 1) / advance;
  std::vector<Sums> parts(2 * pieces - 1);
  parallel_for(parts.size(), [&](std::size_t k) {
    const std::size_t start = k / 2 * advance + (k % 2) * advance;
    const std::size_t length = std::min(k % 2 == 0 ? advance + overlap : overlap, phase.size() - start);
    parts[k] = sums_of_piece(phase.subspan(start, length), longest, false);
  });
  Sums result{std::vector<double>(longest, 0.0)};
  for (std::size_t k = 0; k < parts.size(); ++k) {
    for (std::size_t i = 0; i < longest; ++i) result.values[i] += k % 2 == 0 ? parts[k].values[i] : -parts[k].values[i];
    result.error += parts[k].error;
    result.of_phase = std::max(result.of_phase, parts[k].of_phase);
  }
  return result;
}

/// Factors whose sums still may be off by more than the tolerance.
std::vector<std::size_t> inexact(std::span<const double> sums, std::span<const double> errors) {
  std::vector<std::size_t> factors;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (!(errors[i] <= tolerance * sums[i])) factors.push_back(i + 1);
  }
  return factors;
}

void sum_directly(std::span<const double> x, std::vector<std::size_t> factors, std::vector<double>& sums,
                  std::vector<double>& errors) {
  const double most = direct_share * static_cast<double>(x.size());
  double terms = 0.0;
  std::reverse(factors.begin(), factors.end());  // the longest have the fewest terms
  for (std::size_t i = 0; i < factors.size(); ++i) {
    terms += static_cast<double>(x.size() - 2 * factors[i]);
    if (terms > most) factors.resize(i);
  }
  std::reverse(factors.begin(), factors.end());
  std::vector<double> found(factors.size(), 0.0);
  add_second_differences(x, factors, found);
  for (std::size_t i = 0; i < factors.size(); ++i) {
    sums[factors[i] - 1] = found[i];
    errors[factors[i] - 1] = 0.0;
  }
}

}  // namespace

std::vector<double> every_second_difference_sum(std::span<const double> phase, std::vector<double>& rounding) {
  const std::size_t longest = (phase.size() - 1) / 2;
  std::vector<double> sums(longest, 0.0), errors(longest, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> left(longest);
  std::iota(left.begin(), left.end(), std::size_t{1});
  // First the whole record, then pieces, for ever shorter tau.
  for (std::size_t reach = longest; left.size() > few && reach > few; reach /= reach == longest ? 64 : 32) {
    const auto shortest_left = left.front();
    if (shortest_left > reach) break;
    const auto found = reach == longest ? sums_of_piece(phase, longest, true) : sums_in_pieces(phase, reach);
    for (const std::size_t m : left) {
      if (m > reach) break;
      sums[m - 1] = std::max(0.0, found.values[m - 1]);
      errors[m - 1] = found.error_of(sums[m - 1]);
    }
    left = inexact(sums, errors);
  }
  sum_directly(phase, left, sums, errors);
  rounding.resize(longest);
  for (std::size_t i = 0; i < longest; ++i) rounding[i] = errors[i] > 0.0 ? errors[i] / sums[i] : 0.0;
  return sums;
}

EveryTau every_overlapping_allan(std::span<const double> rate) {
  const Phase phase = integrate_rate(rate, 3);
  const std::size_t longest = rate.size() / 2;
  std::vector<double> sums(longest, 0.0), errors(longest, 0.0), rounding;
  EveryTau result{std::vector<double>(longest, 0.0), std::vector<std::size_t>(longest, 0), {}};
  for (const auto& run : phase.runs) {
    const auto found = every_second_difference_sum({phase.values.data() + run.first, run.points()}, rounding);
    for (std::size_t i = 0; i < found.size(); ++i) {
      sums[i] += found[i];
      errors[i] += rounding[i] * found[i];
      result.count[i] += run.points() - 2 * (i + 1);
    }
  }
  result.rounding.resize(longest);
  for (std::size_t i = 0; i < longest; ++i) {
    if (!std::isfinite(sums[i]))
      throw Error(Error::Kind::bad_data, "the values are too large to be squared and summed: check their unit");
    if (result.count[i] == 0) continue;
    result.deviation[i] =
        std::sqrt(sums[i] / (2.0 * static_cast<double>(result.count[i]))) / static_cast<double>(i + 1);
    result.rounding[i] = std::max(tolerance, sums[i] > 0.0 ? 0.5 * errors[i] / sums[i] : 0.0);
  }
  return result;
}

}  // namespace tumble
