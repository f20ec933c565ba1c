#pragma once

#include <array>

namespace tumble {

/// The size of a unit, exactly: a product of half powers of pi and of the primes that the definitions of units contain
/// (9.80665 = 7 * 28019 / 20000). So deg/h, h^1.5 and sqrt(h) are rounded once, at the end, independent of the path to
/// them.
struct Factor {
  static constexpr std::array<int, 5> primes{2, 3, 5, 7, 28019};
  std::array<int, primes.size()> halves{};  ///< exponents of the primes, in halves
  int pi_halves = 0;

  friend bool operator==(const Factor&, const Factor&) = default;
};

/// numerator / denominator * pi^pi_power; both integers must be products of Factor::primes.
Factor exact_factor(long numerator, long denominator = 1, int pi_power = 0);
Factor power_of_ten(int exponent);
Factor operator*(const Factor& a, const Factor& b);

/// factor^(halves/2). Each exponent of the result must be a whole number of halves.
Factor raised(const Factor& factor, int halves);

/// The nearest double [SI per unit]; infinity or zero beyond its range.
double rounded(const Factor& factor);

}  // namespace tumble
