#include "tumble/methods/random_vibration/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "tumble/math/normal.hpp"
#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::random_vibration {
namespace {

/// Steps of Simpson's rule for a lobe of the window and for a doubling of the frequency, at least twice as many in a
/// part of the spectrum, and at most.
constexpr double steps_of_lobe = 100.0, least_steps = 200.0, most_steps = 5e5;
constexpr double least_value = -9.0, greatest_value = 12.0;  ///< [sd] beyond which the distribution function is 0 and 1

double normal_density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(2.0 * pi); }

}  // namespace

double window_variance(const SpectralDensity& psd, double window) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < psd.frequency.size(); ++i) {
    const double low = psd.frequency[i], high = psd.frequency[i + 1];
    const double slope = std::log(psd.density[i + 1] / psd.density[i]) / std::log(high / low);
    const auto at = [&](double f) {
      const double s = vibration::sinc(f * window);
      return psd.density[i] * std::pow(f / low, slope) * s * s;
    };
    // Simpson's rule, at least 100 steps for a lobe of the window and for a doubling of the frequency.
    const double steps =
        std::max({least_steps, steps_of_lobe * (high - low) * window, steps_of_lobe * (high - low) / low});
    const auto n = 2 * static_cast<std::size_t>(std::min(most_steps, steps));
    const double h = (high - low) / static_cast<double>(n);
    double part = at(low) + at(high);
    for (std::size_t k = 1; k < n; ++k) part += (k % 2 == 1 ? 4.0 : 2.0) * at(low + static_cast<double>(k) * h);
    sum += part * h / 3.0;
  }
  return sum;
}

double velocity_variance(const SpectralDensity& psd) {
  SpectralDensity velocity = psd;
  for (std::size_t i = 0; i < psd.frequency.size(); ++i)
    velocity.density[i] /= std::pow(2.0 * pi * psd.frequency[i], 2);
  return variance(velocity);
}

double density_of_square(const SpectralDensity& psd) {
  SpectralDensity squared = psd;
  for (double& s : squared.density) s *= s;
  return variance(squared);
}

Extreme greatest_of(double n) {
  // Moments of the distribution function Phi(x)^n over x, in steps of 0.002 from where it is nothing to where it is 1.
  Extreme out;
  double before = 0.0, square = 0.0;
  constexpr double step = 0.002;
  for (double x = least_value; x < greatest_value; x += step) {
    const double now = std::exp(n * std::log1p(-normal_above(x + 0.5 * step)));
    out.mean += x * (now - before);
    square += x * x * (now - before);
    before = now;
  }
  out.sd = std::sqrt(std::max(0.0, square - out.mean * out.mean));
  return out;
}

Clipping clipping(double a_0, double rms, double range) {
  const double low = (-range - a_0) / rms, high = (range - a_0) / rms;
  const double below = normal_below(low), above = normal_above(high);
  const double mean =
      range * (above - below) + a_0 * (1.0 - above - below) + rms * (normal_density(low) - normal_density(high));
  return {below + above, mean - a_0};
}

}  // namespace tumble::random_vibration
