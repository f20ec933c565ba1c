#include "tumble/math/stability/every_tau.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tumble/math/parallel.hpp"
#include "tumble/math/stability/allan_differences.hpp"
#include "tumble/math/stability/allan_phase.hpp"
#include "tumble/math/stability/lagged_products.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double tolerance = 1e-10;
constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr std::size_t few = 64;         // factors that are as quickly summed directly
constexpr double direct_share = 512.0;  // and so many at most, each over the whole record

/// Sums of z^2 at m = 1 ... longest and what rounding may do to them.
struct Sums {
  std::vector<double> values;
  double error = 0.0;     ///< of each sum
  double of_phase = 0.0;  ///< of each phase value: 4 sd of its share in a sum S are 6 (order 3: 11) sqrt(S) times this

  double error_of(double sum, std::size_t order) const {
    return error + (order == 2 ? 6.0 : 11.0) * of_phase * std::sqrt(sum);
  }
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

/// The sums over all n with n + 2m < N from products; what the quadratic gave is put back.
void add_second(std::span<const double> x, double curvature, std::size_t longest, bool threads,
                std::vector<double>& values) {
  const auto products = lagged_products(x, longest, threads);
  const auto sum = running_sums(x, false), square = running_sums(x, true);
  const std::size_t size = x.size();
  for (std::size_t m = 1; m <= longest; ++m) {
    const double squares = square[size - 2 * m] + 4.0 * (square[size - m] - square[m]) + (square[size] - square[2 * m]);
    const double lagged =
        2.0 * products.whole[2 * m] - 8.0 * products.whole[m] + 4.0 * (products.leading[m] + products.trailing[m]);
    const double differences = sum[size - 2 * m] - 2.0 * (sum[size - m] - sum[m]) + (sum[size] - sum[2 * m]);
    const double constant = 2.0 * curvature * static_cast<double>(m) * static_cast<double>(m);
    values[m - 1] = (squares + lagged) + constant * (2.0 * differences + constant * static_cast<double>(size - 2 * m));
  }
}

/// Takes the least-squares cubic off phase that is less its quadratic. Returned: its coefficient.
double remove_cubic(std::vector<double>& x) {
  const double middle = 0.5 * (static_cast<double>(x.size()) - 1.0), half = 0.5 * static_cast<double>(x.size());
  const double slope = (12.0 * half * half - 7.0) / 20.0;  // of t^3 - slope t, orthogonal to lower powers
  const auto cubic = [&](std::size_t n) {
    const double t = static_cast<double>(n) - middle;
    return t * (t * t - slope);
  };
  double product = 0.0, square = 0.0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    product += x[n] * cubic(n);
    square += cubic(n) * cubic(n);
  }
  const double coefficient = square > 0.0 ? product / square : 0.0;
  for (std::size_t n = 0; n < x.size(); ++n) x[n] -= coefficient * cubic(n);
  return coefficient;
}

/// The same of third differences; what the cubic gave is put back.
void add_third(std::span<const double> x, double cubic, std::size_t longest, bool threads,
               std::vector<double>& values) {
  const auto products = third_products(x, longest, threads);
  const auto sum = running_sums(x, false), square = running_sums(x, true);
  const std::size_t size = x.size();
  const auto between = [&](const std::vector<double>& sums, std::size_t first, std::size_t last) {
    return sums[last] - sums[first];
  };
  for (std::size_t m = 1; m <= longest; ++m) {
    const std::size_t last = size - 3 * m;
    const double squares = (square[last] + between(square, 3 * m, size)) +
                           9.0 * (between(square, m, last + m) + between(square, 2 * m, last + 2 * m));
    const double whole = 12.0 * products.whole[2 * m] - 2.0 * products.whole[3 * m] - 30.0 * products.whole[m];
    const auto ends = [&](const ThirdProducts::Ends& end) {
      return 18.0 * end.one[m] + 6.0 * (end.two[m] - end.half[m]);
    };
    const double differences =
        (between(sum, 3 * m, size) - sum[last]) + 3.0 * (between(sum, m, last + m) - between(sum, 2 * m, last + 2 * m));
    const double constant = 6.0 * cubic * std::pow(static_cast<double>(m), 3);
    values[m - 1] = ((squares + whole) + (ends(products.leading) + ends(products.trailing))) +
                    constant * (2.0 * differences + constant * static_cast<double>(last));
  }
}

/// The sums of a piece of phase of N points over all n with n + order m < N, m = 1 ... longest.
Sums sums_of_piece(std::span<const double> phase, std::size_t order, std::size_t longest, bool threads) {
  std::vector<double> x(phase.begin(), phase.end());
  double largest = 0.0, squares = 0.0;
  for (double& value : x) largest = std::max(largest, std::abs(value -= phase[0]));
  const double curvature = remove_quadratic(x), cubic = order == 3 ? remove_cubic(x) : 0.0;
  for (const double value : x) squares += value * value;
  // Of a sum, over the sum of x^2 and the square of the sum of the difference's coefficients.
  Sums result{std::vector<double>(longest), (order == 2 ? 16.0 : 64.0) * epsilon * squares, epsilon * largest};
  if (order == 2)
    add_second(x, curvature, longest, threads, result.values);
  else
    add_third(x, cubic, longest, threads, result.values);
  return result;
}

/// The sums of the whole from pieces that overlap: terms of a piece less those within its overlap with the next.
Sums sums_in_pieces(std::span<const double> phase, std::size_t order, std::size_t longest) {
  const std::size_t advance = 8 * longest, overlap = order * longest;
  const std::size_t pieces = (phase.size() - overlap + advance - 1) / advance;
  std::vector<Sums> parts(2 * pieces - 1);
  parallel_for(parts.size(), [&](std::size_t k) {
    const std::size_t start = k / 2 * advance + (k % 2) * advance;
    const std::size_t length = std::min(k % 2 == 0 ? advance + overlap : overlap, phase.size() - start);
    parts[k] = sums_of_piece(phase.subspan(start, length), order, longest, false);
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

double third_difference_squares(std::span<const double> x, std::size_t m) {
  double sum = 0.0;
  for (std::size_t n = 0; n + 3 * m < x.size(); ++n) {
    const double z = (x[n + 3 * m] - x[n]) - 3.0 * (x[n + 2 * m] - x[n + m]);
    sum += z * z;
  }
  return sum;
}

void sum_directly(std::span<const double> x, std::size_t order, std::vector<std::size_t> factors,
                  std::vector<double>& sums, std::vector<double>& errors) {
  const double most = direct_share * static_cast<double>(x.size());
  double terms = 0.0;
  const auto worse = [&](std::size_t a, std::size_t b) {  // errors over sums
    return errors[a - 1] * sums[b - 1] > errors[b - 1] * sums[a - 1];
  };
  if (order == 2)
    std::reverse(factors.begin(), factors.end());  // the longest have the fewest terms
  else
    std::stable_sort(factors.begin(), factors.end(), worse);
  for (std::size_t i = 0; i < factors.size(); ++i) {
    terms += static_cast<double>(x.size() - order * factors[i]);
    if (terms > most) factors.resize(i);
  }
  std::sort(factors.begin(), factors.end());
  std::vector<double> found(factors.size(), 0.0);
  if (order == 2)
    add_second_differences(x, factors, found);
  else
    parallel_for(factors.size(), [&](std::size_t i) { found[i] = third_difference_squares(x, factors[i]); });
  for (std::size_t i = 0; i < factors.size(); ++i) {
    sums[factors[i] - 1] = found[i];
    errors[factors[i] - 1] = 0.0;
  }
}

/// The runs of a rate signal together.
EveryTau every_deviation(std::span<const double> rate, std::size_t order) {
  const Phase phase = integrate_rate(rate, 3);
  const std::size_t longest = rate.size() / order;
  std::vector<double> sums(longest, 0.0), errors(longest, 0.0), rounding;
  EveryTau result{std::vector<double>(longest, 0.0), std::vector<std::size_t>(longest, 0), {}};
  for (const auto& run : phase.runs) {
    const auto found = every_difference_sum({phase.values.data() + run.first, run.points()}, order, rounding);
    for (std::size_t i = 0; i < found.size(); ++i) {
      sums[i] += found[i];
      errors[i] += rounding[i] * found[i];
      result.count[i] += run.points() - order * (i + 1);
    }
  }
  result.rounding.resize(longest);
  for (std::size_t i = 0; i < longest; ++i) {
    if (!std::isfinite(sums[i]))
      throw Error(Error::Kind::bad_data, "the values are too large to be squared and summed: check their unit");
    if (result.count[i] == 0) continue;
    result.deviation[i] = std::sqrt(sums[i] / ((order == 2 ? 2.0 : 6.0) * static_cast<double>(result.count[i]))) /
                          static_cast<double>(i + 1);
    result.rounding[i] = std::max(tolerance, sums[i] > 0.0 ? 0.5 * errors[i] / sums[i] : 0.0);
  }
  return result;
}

}  // namespace

std::vector<double> every_difference_sum(std::span<const double> phase, std::size_t order,
                                         std::vector<double>& rounding) {
  const std::size_t longest = (phase.size() - 1) / order;
  std::vector<double> sums(longest, 0.0), errors(longest, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> left(longest);
  std::iota(left.begin(), left.end(), std::size_t{1});
  // First the whole record, then pieces, for ever shorter tau.
  const std::size_t step = order == 2 ? 32 : 8;  // third differences of steep noise are smaller against the phase
  for (std::size_t reach = longest; left.size() > few && reach > few; reach /= reach == longest ? 2 * step : step) {
    const auto shortest_left = left.front();
    if (shortest_left > reach) break;
    const auto found =
        reach == longest ? sums_of_piece(phase, order, longest, true) : sums_in_pieces(phase, order, reach);
    for (const std::size_t m : left) {
      if (m > reach) break;
      sums[m - 1] = std::max(0.0, found.values[m - 1]);
      errors[m - 1] = found.error_of(sums[m - 1], order);
    }
    left = inexact(sums, errors);
  }
  sum_directly(phase, order, left, sums, errors);
  rounding.resize(longest);
  for (std::size_t i = 0; i < longest; ++i) rounding[i] = errors[i] > 0.0 ? errors[i] / sums[i] : 0.0;
  return sums;
}

EveryTau every_overlapping_allan(std::span<const double> rate) { return every_deviation(rate, 2); }

EveryTau every_overlapping_hadamard(std::span<const double> rate) { return every_deviation(rate, 3); }

}  // namespace tumble
