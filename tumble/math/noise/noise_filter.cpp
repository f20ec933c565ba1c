#include "tumble/math/noise/noise_filter.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "tumble/math/noise/block_cosines.hpp"
#include "tumble/math/noise/noise_bands/expected.hpp"
#include "tumble/math/noise/noise_bands/lost_samples.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

using Complex = std::complex<double>;

constexpr double critical = 1e-4;  ///< about a damping of 1, where the two exponentials are one: it is moved by as much
constexpr double sine_of_zero = 1e-12;  ///< of a frequency that is a multiple of half the rate, to rounding

constexpr double negligible = 1e-7;

/// A part a exp(-rate |t|) of an autocovariance.
struct Exponential {
  Complex size, rate;
};

/// Poles of a unit low pass as the exponentials of its autocovariance [1/samples].
std::vector<Exponential> exponentials_of(const NoiseFilter& filter) {
  const double w = two_pi * filter.bandwidth;
  if (!filter.two_poles()) return {{1.0, w}};
  const double zeta = std::abs(filter.damping - 1.0) < critical ? 1.0 + critical : filter.damping;
  const double half = 1.0 - 2.0 * zeta * zeta, natural = w / std::sqrt(half + std::sqrt(half * half + 1.0));
  // exp(-zeta w t) (cos(v t) + zeta w/v sin(v t)), v = w sqrt(1 - zeta^2), imaginary beyond zeta = 1
  const Complex v = natural * std::sqrt(Complex(1.0 - zeta * zeta)), i(0.0, 1.0);
  const Complex turn = zeta * natural / (i * v);
  return {{0.5 * (1.0 + turn), zeta * natural - i * v}, {0.5 * (1.0 - turn), zeta * natural + i * v}};
}

double at_lag(const std::vector<Exponential>& parts, bool means, int h) {
  Complex sum = 0.0;
  for (const auto& [size, rate] : parts) {
    const Complex gone = 1.0 - std::exp(-rate);
    if (!means)
      sum += size * std::exp(-static_cast<double>(h) * rate);
    else
      sum += size *
             (h == 0 ? 2.0 * (rate - gone) / (rate * rate) : std::exp(-(h - 1.0) * rate) * gone * gone / (rate * rate));
  }
  return sum.real();
}

/// Convolution of p boxes of length 1 with itself, at x [lengths]: a B-spline of order 2 p.
double spline(int p, double x) {
  const int n = 2 * p;
  double sum = 0.0, factor = 1.0, factorial = 1.0;
  for (int k = 2; k < n; ++k) factorial *= k;
  for (int k = 0; k <= n; ++k) {
    const double off = x + p - k;
    if (off > 0.0) sum += factor * std::pow(off, n - 1);
    factor *= -static_cast<double>(n - k) / (k + 1.0);
  }
  return std::max(0.0, sum / factorial);
}

/// Number of running means, one after the other.
int means_of(FilterShape shape) { return shape == FilterShape::mean ? 1 : shape == FilterShape::mean_of_means ? 2 : 3; }

bool is_mean(FilterShape shape) {
  return shape == FilterShape::mean || shape == FilterShape::mean_of_means || shape == FilterShape::third_mean;
}

}  // namespace

std::string filter_name(const NoiseFilter& filter) {
  switch (filter.shape) {
    case FilterShape::none:
      return "none";
    case FilterShape::first_order:
    case FilterShape::first_order_means:
      return "low pass of first order";
    case FilterShape::second_order:
    case FilterShape::second_order_means:
      return "low pass of second order";
    case FilterShape::mean:
      return "running mean";
    case FilterShape::mean_of_means:
    case FilterShape::third_mean:
      break;
  }
  return filter.shape == FilterShape::mean_of_means ? "decimation by sinc^2" : "decimation by sinc^3";
}

double bandwidth_of_means(FilterShape shape, double length) {
  // (sin x/x)^(2 p) = 1/2, x = pi f length
  constexpr double x[] = {1.391557378251510, 1.001929930293026, 0.823562985282098};
  return x[means_of(shape) - 1] / (pi * length);
}

std::vector<double> filtered_autocovariance(const NoiseFilter& filter) {
  std::vector<double> lags;
  if (!filter.given()) return lags;
  double sum = 0.0;
  constexpr int most = 4000;
  if (is_mean(filter.shape)) {
    const double length = bandwidth_of_means(filter.shape, 1.0) / filter.bandwidth;
    const int p = means_of(filter.shape);
    for (int h = 0; h < p * length; ++h) lags.push_back(spline(p, h / length));
  } else {
    const auto parts = exponentials_of(filter);
    const bool means =
        filter.shape == FilterShape::first_order_means || filter.shape == FilterShape::second_order_means;
    double slowest = INFINITY;
    for (const auto& part : parts) slowest = std::min(slowest, part.rate.real());
    const int last = std::min(most, 2 + static_cast<int>(-std::log(negligible) / slowest));
    for (int h = 0; h <= last; ++h) lags.push_back(at_lag(parts, means, h));
  }
  for (std::size_t h = 0; h < lags.size(); ++h) sum += (h == 0 ? 1.0 : 2.0) * lags[h];
  for (double& lag : lags) lag /= sum;
  return lags;
}

double power_gain(const NoiseFilter& filter, double frequency) {
  if (!filter.given()) return 1.0;
  const auto lags = filtered_autocovariance(filter);
  double sum = lags[0];
  for (std::size_t h = 1; h < lags.size(); ++h)
    sum += 2.0 * lags[h] * std::cos(two_pi * frequency * static_cast<double>(h));
  return std::max(0.0, sum);
}

double mean_covariance(std::span<const double> autocovariance, double unit, int h) {
  if (autocovariance.empty()) return h == 0 ? 1.0 / unit : 0.0;
  const auto last = static_cast<double>(autocovariance.size()) - 1.0;
  double sum = 0.0;
  for (double lag = std::max(-last, (h - 1.0) * unit + 1.0); lag <= std::min(last, (h + 1.0) * unit - 1.0); ++lag)
    sum += (unit - std::abs(lag - h * unit)) * autocovariance[static_cast<std::size_t>(std::abs(lag))];
  return sum / (unit * unit);
}

namespace {

/// Of means over the unit of a band, shared by all bands of this unit.
struct FilteredMeans {
  double lost = 0.0;                ///< [1] what missing samples add to the variance
  std::vector<double> covariances;  ///< [1] at lags 0, 1, ... units
};

FilteredMeans means_for(const NoiseBand& band, std::span<const double> autocovariance) {
  FilteredMeans means;
  if (band.lost != nullptr) means.lost = band.lost->filtered_variance(autocovariance);
  const auto reach = static_cast<std::size_t>(static_cast<double>(autocovariance.size()) / band.unit) + 1;
  for (std::size_t h = 0; h < std::max(reach + 3, static_cast<std::size_t>(widest_block)); ++h)
    means.covariances.push_back(mean_covariance(autocovariance, band.unit, static_cast<int>(h)));
  return means;
}

double expected_in(const NoiseBand& band, const FilteredMeans& means) {
  const auto& covariances = means.covariances;
  if (band.radix > 0) {
    const auto& products = band.products.empty() ? cosine_products(band.radix, band.order) : band.products;
    double sum = (means.lost + covariances[0]) * products[0];
    for (std::size_t h = 1; h < products.size(); ++h) sum += 2.0 * products[h] * covariances[h];
    return sum;
  }
  // Covariances of differences at lag h, g_h: g_0 + 2 sum_h g_h ((1 - h/(n+1)) cos(h w) + sin(h w) cot(w)/(n+1))
  const double w = two_pi * band.frequency * band.unit, sine = std::sin(w);
  const double cotangent = std::abs(sine) < sine_of_zero ? 0.0 : std::cos(w) / sine;
  double sum = 2.0 * (covariances[0] - covariances[1]);
  const Complex turn = std::polar(1.0, w);
  Complex turned = turn;  // exp(i h w)
  for (std::size_t h = 1; h + 1 < covariances.size(); ++h) {
    const double g = 2.0 * covariances[h] - covariances[h - 1] - covariances[h + 1];
    sum +=
        2.0 * g *
        ((1.0 - static_cast<double>(h) * band.shortness) * turned.real() + band.shortness * turned.imag() * cotangent);
    turned *= turn;
  }
  return sum + means.lost * (2.0 - 2.0 * std::cos(w));
}

}  // namespace

std::vector<double> expected_filtered(std::span<const NoiseBand> bands, const NoiseFilter& filter) {
  const auto autocovariance = filtered_autocovariance(filter);
  FilteredMeans means;
  std::vector<double> expected;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    if (i == 0 || bands[i].unit != bands[i - 1].unit || bands[i].lost != bands[i - 1].lost)
      means = autocovariance.empty() ? FilteredMeans() : means_for(bands[i], autocovariance);
    expected.push_back(autocovariance.empty() ? bands[i].expected[1] : expected_in(bands[i], means));
  }
  return expected;
}

}  // namespace tumble
