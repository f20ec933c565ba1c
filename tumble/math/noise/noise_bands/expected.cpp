#include "tumble/math/noise/noise_bands/expected.hpp"

#include <cmath>
#include <complex>
#include <cstddef>

#include "tumble/math/noise/noise_bands.hpp"
#include "tumble/math/noise/noise_bands/lost_samples.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

/// [steps] where the series of a difference is exact to rounding and the difference cancels.
constexpr double series_from = 16.0;
/// [correlation times] of a mean, below which the formula cancels and its series does not.
constexpr double short_means = 0.02;
constexpr double no_sine = 1e-12;  ///< of a frequency that is a multiple of half the rate, to rounding

/// Second difference of t^2 ln t at t and steps of 1, by its series beyond t = 16.
double second_difference(double t) {
  const auto f = [](double x) { return x == 0.0 ? 0.0 : x * x * std::log(std::abs(x)); };
  if (t < series_from) return f(t + 1.0) - 2.0 * f(t) + f(t - 1.0);
  const double u = 1.0 / (t * t);
  return 2.0 * std::log(t) + 3.0 - u * (1.0 / 6.0 + u * (1.0 / 30.0 + u / 84.0));
}

/// Means over r = unit/T_c of a Gauss-Markov process of unit variance: variance, covariance of neighbours, and what is
/// left of it one unit on.
struct MarkovMeans {
  explicit MarkovMeans(double r) : decay(std::exp(-r)) {
    const double gone = -std::expm1(-r);
    next = gone * gone / (r * r);
    if (r < short_means) {
      // 2 (r - 1 + exp(-r))/r^2 and, without cancellation, that less `next`.
      variance = 1.0 - r / 3.0 + r * r / 12.0 - r * r * r / 60.0;
      drop = r * (2.0 / 3.0 - r * (0.5 - r * (7.0 / 30.0 - r / 12.0)));
    } else {
      variance = 2.0 * (r - gone) / (r * r);
      drop = variance - next;
    }
  }
  double decay, variance, next, drop;
};

}  // namespace

double fourth_difference(double t) {
  if (t < series_from)
    return second_difference(t + 1.0) - 2.0 * second_difference(t) + second_difference(std::abs(t - 1.0));
  const double u = 1.0 / (t * t);
  return -u * (2.0 + u * (2.0 + u * (3.0 + u * 17.0 / 3.0)));
}

const std::vector<double>& cosine_products(int radix, int order) {
  static const auto table = [] {
    std::vector<std::vector<std::vector<double>>> all(widest_block + 1);
    for (int p = 2; p <= widest_block; ++p)
      for (int k = 0; k < p; ++k) {
        std::vector<double> products(static_cast<std::size_t>(p), 0.0);
        for (int h = 0; h < p; ++h)
          for (int i = 0; i + h < p; ++i)
            products[static_cast<std::size_t>(h)] +=
                2.0 / p * std::cos(pi * k * (i + 0.5) / p) * std::cos(pi * k * (i + h + 0.5) / p);
        all[static_cast<std::size_t>(p)].push_back(products);
      }
    return all;
  }();
  return table[static_cast<std::size_t>(radix)][static_cast<std::size_t>(order)];
}

double unit_covariance(NoiseTerm term, double unit, int h) {
  switch (term) {
    case NoiseTerm::quantization:
      return (h == 0 ? 2.0 : h == 1 ? -1.0 : 0.0) / (unit * unit);
    case NoiseTerm::white:
      return h == 0 ? 1.0 / unit : 0.0;
    case NoiseTerm::flicker:
      return -second_difference(h) / (2.0 * pi);
    case NoiseTerm::random_walk: {
      const auto cube = [](int x) { return std::pow(std::abs(x), 3); };
      return -unit * (cube(h + 1) - 2.0 * cube(h) + cube(h - 1)) / 12.0;
    }
    case NoiseTerm::markov:
      break;
  }
  return 0.0;
}

std::vector<double> markov_below_variance(double unit, double time, int lags) {
  const MarkovMeans means(unit / time);
  std::vector<double> below(static_cast<std::size_t>(lags), 0.0);
  double value = -means.drop, covariance = means.next;
  for (std::size_t h = 1; h < below.size(); ++h) {
    below[h] = value;
    value -= covariance * (1.0 - means.decay);
    covariance *= means.decay;
  }
  return below;
}

double expected_markov(const NoiseBand& band, double time) {
  const MarkovMeans means(band.unit / time);
  const double lost = band.lost == nullptr ? 0.0 : band.lost->markov_variance(time);
  if (band.radix > 0) {
    const auto& products = band.products.empty() ? cosine_products(band.radix, band.order) : band.products;
    // Covariances less the variance, which weights that add up to zero do not see: no cancellation.
    return over_lags(products, markov_below_variance(band.unit, time, band.radix)) + lost * products[0];
  }
  const double w = 2.0 * pi * band.frequency * band.unit, gone = 1.0 - means.decay;
  const double beyond = means.next * gone * gone;  // minus the covariance of differences at lag 2
  const double zero = 2.0 * means.drop, one = means.next * gone - means.drop;
  const std::complex<double> z = std::polar(means.decay, w), turn = std::polar(1.0, 2.0 * w);
  const std::complex<double> sum = turn / (1.0 - z), lags = turn * (2.0 - z) / ((1.0 - z) * (1.0 - z));
  const double cotangent = std::abs(std::sin(w)) < no_sine ? 0.0 : std::cos(w) / std::sin(w);
  const double first = (1.0 - band.shortness) * std::cos(w) + band.shortness * std::cos(w);
  const double others = sum.real() - band.shortness * lags.real() + band.shortness * cotangent * sum.imag();
  return zero + 2.0 * (one * first - beyond * others) + lost * (2.0 - 2.0 * std::cos(w));
}

}  // namespace tumble
