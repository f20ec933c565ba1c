#include "tumble/units/factor.hpp"

#include <boost/math/constants/constants.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cassert>
#include <cstddef>

namespace tumble {

namespace {

using Long = boost::multiprecision::cpp_bin_float_50;

void multiply_in(Factor& factor, long number, int sign) {
  for (std::size_t i = 0; i < Factor::primes.size(); ++i)
    for (; number % Factor::primes[i] == 0; number /= Factor::primes[i]) factor.halves[i] += 2 * sign;
  assert(number == 1);
}

Long half_power(const Long& base, int halves) {
  const Long whole = boost::multiprecision::pow(base, halves / 2);
  if (halves % 2 == 0) return whole;
  const Long root = boost::multiprecision::sqrt(base);
  return halves > 0 ? Long(whole * root) : Long(whole / root);
}

}  // namespace

Factor exact_factor(long numerator, long denominator, int pi_power) {
  Factor factor;
  multiply_in(factor, numerator, 1);
  multiply_in(factor, denominator, -1);
  factor.pi_halves = 2 * pi_power;
  return factor;
}

Factor power_of_ten(int exponent) {
  Factor factor;
  factor.halves[0] = factor.halves[2] = 2 * exponent;
  return factor;
}

Factor operator*(const Factor& a, const Factor& b) {
  Factor product = a;
  for (std::size_t i = 0; i < a.halves.size(); ++i) product.halves[i] += b.halves[i];
  product.pi_halves += b.pi_halves;
  return product;
}

Factor raised(const Factor& factor, int halves) {
  Factor result = factor;
  for (int& exponent : result.halves) {
    assert(exponent * halves % 2 == 0);
    exponent = exponent * halves / 2;
  }
  result.pi_halves = factor.pi_halves * halves / 2;
  return result;
}

double rounded(const Factor& factor) {
  Long value = half_power(boost::math::constants::pi<Long>(), factor.pi_halves);
  for (std::size_t i = 0; i < factor.halves.size(); ++i)
    if (factor.halves[i] != 0) value *= half_power(Long(Factor::primes[i]), factor.halves[i]);
  return value.convert_to<double>();
}

}  // namespace tumble
