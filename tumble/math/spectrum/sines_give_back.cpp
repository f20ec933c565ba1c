// What fitted sines take of the noise beside them, given back to its bands.
#include <algorithm>
#include <cmath>

#include "tumble/math/spectrum/sines.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {

namespace {

/// [1] of a band, that remains beside the sines at least: a greater factor is no estimate.
constexpr double least_power = 0.05;
constexpr double least_count = 0.3;  ///< degrees of freedom of a band that is used

}  // namespace

/// The three directions of a sine at the values that the slow sines are taken of: amplitude, phase and frequency.
/// Those of `weight` are orthogonal under it.
std::array<std::vector<double>, 3> Sines::directions(const Sine& sine, const NoiseBands& bands,
                                                     const std::vector<double>& weight) const {
  const std::size_t values = bands.slow.size();
  double all = 0.0, mean = 0.0;
  for (std::size_t k = 0; k < values; ++k) {
    all += weight[k];
    mean += weight[k] * static_cast<double>(k);
  }
  mean /= all;
  std::array<std::vector<double>, 3> x;
  const std::complex<double> phase = sine.amplitude / std::abs(sine.amplitude);
  for (std::size_t k = 0; k < values; ++k) {
    const double time = (static_cast<double>(k) + 0.5) * bands.slow_unit - 0.5 - middle_;
    const std::complex<double> at = phase * std::polar(1.0, two_pi * sine.frequency * time);
    x[0].push_back(at.real());
    x[1].push_back(at.imag());
    x[2].push_back(at.imag() * (static_cast<double>(k) - mean));
  }
  for (auto& column : x) {
    double scale = 0.0;
    for (std::size_t k = 0; k < values; ++k) scale += weight[k] * column[k] * column[k];
    for (std::size_t k = 0; k < values; ++k)
      column[k] = std::isnan(bands.slow[k]) ? bands.slow[k] : column[k] / std::sqrt(scale);
  }
  return x;
}

/// With x the directions and g = w x the weights of their estimates, the noise e leaves e - sum x (g e): of a contrast
/// c in white noise of unit variance this is less by 2 (c x)(c g) - var (c x)^2, and the record has lost (c x)(c g) of
/// a degree of freedom. Near the sine, where all this is, the noise is white.
void Sines::give_back(const std::vector<double>& expected, const std::function<double(double)>& level,
                      NoiseBands& bands) const {
  const double unit = bands.slow_unit;
  std::vector<double> power(bands.bands.size(), 0.0), freedom(bands.bands.size(), 0.0);
  for (const Sine& sine : sines_) {
    if (sine.frequency * unit >= 0.5) continue;  // in bands of so many contrasts that three matter little
    std::vector<double> weight(bands.slow.size(), 0.0);
    for (const Support& support : supports(sine.frequency))
      for (std::size_t k = 0; k < weight.size(); ++k) {
        const auto n = static_cast<std::size_t>((static_cast<double>(k) + 0.5) * unit);
        if (n >= support.begin && n < support.end && !std::isnan(bands.slow[k])) weight[k] = support.weight(n);
      }
    const double white = level(sine.frequency) / unit;
    for (const auto& x : directions(sine, bands, weight)) {
      std::vector<double> g(x);
      double variance = 0.0;
      for (std::size_t k = 0; k < x.size(); ++k) {
        g[k] *= weight[k];
        if (weight[k] > 0.0) variance += g[k] * g[k];
      }
      const auto of_x = slow_sines(x), of_g = slow_sines(g);
      for (std::size_t i = 0; i < of_x.size(); ++i) {
        const std::size_t b = bands.ordinates[i].band;
        const double share = white / (expected[b] * bands.bands[b].count), hat = of_x[i] * of_g[i];
        freedom[b] += share * hat;
        power[b] += share * (2.0 * hat - variance * of_x[i] * of_x[i]);
      }
    }
  }
  for (std::size_t b = 0; b < bands.bands.size(); ++b) {
    NoiseBand& band = bands.bands[b];
    const double there = std::max(least_power, 1.0 - power[b]);
    band.count *= std::clamp(1.0 - freedom[b], 0.0, 1.0);
    band.mean_square /= there;
    band.with_ramp /= std::sqrt(there);
  }
  std::erase_if(bands.bands, [](const NoiseBand& band) { return band.count < least_count; });
}

}  // namespace tumble
