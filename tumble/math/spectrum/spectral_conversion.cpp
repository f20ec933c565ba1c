#include "tumble/math/spectrum/spectral_conversion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tumble/math/square.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double half_rate_rounding = 1e-12;  ///< [1] of half the rate, by which a frequency may be above it
constexpr double longest_octave = 1.5, part_of_lobe = 0.25;  ///< ratio of the ends of a part; [1] of a lobe of the mean

/// Gauss-Legendre, 8 points on -1 ... 1.
constexpr std::array<double, 4> nodes{0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
constexpr std::array<double, 4> weights{0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};

template <class Function>
double integral(double low, double high, const Function& function) {
  const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
  double sum = 0.0;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    sum += weights[i] * (function(middle - half * nodes[i]) + function(middle + half * nodes[i]));
  return half * sum;
}

void check(std::span<const double> frequency, std::span<const double> density, double rate, std::size_t factor) {
  Problems problems;
  if (!(rate > 0.0 && std::isfinite(rate))) problems.push_back("sampling rate must be above 0 Hz");
  if (factor == 0) problems.push_back("averaging factor must be 1 or more");
  if (frequency.size() != density.size() || frequency.size() < 2)
    problems.push_back("as many densities as frequencies are needed, and at least 2");
  for (std::size_t i = 0; i < frequency.size(); ++i) {
    const double before = i == 0 ? 0.0 : frequency[i - 1];
    if (frequency[i] > before && frequency[i] <= 0.5 * rate * (1.0 + half_rate_rounding)) continue;
    problems.push_back(say("frequencies must ascend from above 0 to at most half the sampling rate: see number {}",
                           Name{std::to_string(i)}));
    break;
  }
  if (std::any_of(density.begin(), density.end(), [](double one) { return !(one >= 0.0 && std::isfinite(one)); }))
    problems.push_back("a density must be finite and not below 0");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// Two-sided densities without quantization, whose samples are no means over an interval.
double two_sided(const NoiseModel& noise, double f) {
  double density = square(noise.angle_random_walk) + square(noise.bias_instability) / (2.0 * pi * f) +
                   square(noise.rate_random_walk / (2.0 * pi * f));
  if (noise.markov_sd != 0.0 && noise.markov_time > 0.0)
    density += 2.0 * square(noise.markov_sd) * noise.markov_time / (1.0 + square(2.0 * pi * f * noise.markov_time));
  return density;
}

}  // namespace

double stability_transfer(Stability measure, double frequency, std::size_t factor) {
  const double x = pi * frequency, m = static_cast<double>(factor);
  const double fast = std::sin(m * x), slow = m * std::sin(x);
  // Mean over m samples: sin(m x)/(m sin x), 1 at zero.
  const double mean = slow == 0.0 ? 1.0 : fast / slow;
  switch (measure) {
    case Stability::allan:
    case Stability::overlapping_allan:
      return 2.0 * square(fast * mean);
    case Stability::modified_allan:
      return 2.0 * square(fast * mean * mean);
    case Stability::hadamard:
    case Stability::overlapping_hadamard:
      return 8.0 / 3.0 * square(fast * fast * mean);
    default:
      throw Error(Error::Kind::unsupported,
                  "a transfer function is given for the Allan, modified Allan and Hadamard variances");
  }
}

double stability_variance_from_spectrum(Stability measure, std::span<const double> frequency,
                                        std::span<const double> density, double rate, std::size_t factor) {
  check(frequency, density, rate, factor);
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < frequency.size(); ++i) {
    const double low = frequency[i], high = frequency[i + 1];
    const bool law = density[i] > 0.0 && density[i + 1] > 0.0;
    const double exponent = law ? std::log(density[i + 1] / density[i]) / std::log(high / low) : 0.0;
    const double slope = (density[i + 1] - density[i]) / (high - low);
    const auto weighted = [&](double f) {
      const double s = law ? density[i] * std::pow(f / low, exponent) : density[i] + slope * (f - low);
      return s * stability_transfer(measure, f / rate, factor);
    };
    // Pieces over which the transfer function turns by a quarter at most, and frequency grows by half at most.
    for (double from = low; from < high;) {
      const double to =
          std::min({high, longest_octave * from, from + part_of_lobe * rate / static_cast<double>(factor)});
      sum += integral(from, to, weighted);
      if (to == high) break;
      from = to;
    }
  }
  return sum;
}

double continuous_density(const NoiseModel& noise, double frequency, double rate) {
  return 2.0 * (two_sided(noise, frequency) + square(2.0 * pi * frequency * noise.quantization_noise) / rate);
}

double sampled_density(const NoiseModel& noise, double frequency, double rate) {
  const double sine = square(std::sin(pi * frequency / rate));
  // White noise stays flat; the angle's white samples are differenced.
  double density = square(noise.angle_random_walk) + 4.0 * sine * square(noise.quantization_noise) * rate;
  NoiseModel coloured = noise;
  coloured.angle_random_walk = 0.0;
  constexpr int aliases = 64;
  for (int k = -aliases; k <= aliases; ++k) {
    const double f = std::abs(frequency + k * rate);
    density += sine / square(pi * f / rate) * two_sided(coloured, f);
  }
  // What lies beyond, of flicker as 1/f^3: two sums from k = aliases + 1/2 on.
  density += sine / square(pi) * square(coloured.bias_instability) / (2.0 * pi * rate) / square(aliases + 0.5);
  return 2.0 * density;
}

}  // namespace tumble
