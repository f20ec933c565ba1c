#include "tumble/methods/allan_noise/ramp.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "tumble/math/noise/whitening.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/methods/allan_noise/describe.hpp"

namespace tumble::allan_noise {
namespace {

constexpr double most_freedom = 1e6;  ///< [1] more is infinite: the quantiles agree to 1e-6

constexpr std::size_t most_ramp_averages = 4096;

struct RampAverages {
  Matrix design;  ///< one row an average: 1, time [s] from the middle of the record, mean
  std::vector<double> share;
  double interval = 0.0;
};

RampAverages averages_of(std::span<const double> values, double rate) {
  const std::size_t stride = (values.size() + most_ramp_averages - 1) / most_ramp_averages, n = values.size() / stride;
  RampAverages averages{Matrix(n, 3), std::vector<double>(n, 0.0), static_cast<double>(stride) / rate};
  double origin = 0.0;
  for (const double value : values)
    if (!std::isnan(value)) origin = value;
  for (std::size_t k = 0; k < n; ++k) {
    double sum = 0.0, count = 0.0;
    for (const double value : values.subspan(k * stride, stride))
      if (!std::isnan(value)) {
        sum += value - origin;
        ++count;
      }
    averages.share[k] = count / static_cast<double>(stride);
    averages.design(k, 0) = 1.0;
    averages.design(k, 1) = (static_cast<double>(k) - 0.5 * static_cast<double>(n - 1)) * averages.interval;
    averages.design(k, 2) = count > 0.0 ? sum / count : 0.0;
  }
  return averages;
}

struct Line {
  double slope, variance;
};

Line regress(const RampAverages& averages, const NoiseModel& noise) {
  Matrix block = averages.design;
  const std::size_t n = block.rows;
  Whitening(noise, averages.interval, averages.interval * static_cast<double>(n))(block, averages.share);
  double s[3][3] = {};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < n; ++k) s[i][j] += block(k, i) * block(k, j);
  const double centred = s[1][1] - s[0][1] * s[0][1] / s[0][0];
  return {(s[1][2] - s[0][1] * s[0][2] / s[0][0]) / centred, 1.0 / centred};
}

NoiseModel noise_of(const std::vector<FittedTerm>& terms, const std::vector<double>& squared, double rate,
                    double interval) {
  NoiseModel noise;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const NoiseTerm term = terms[t].unit.term;
    const double value = coefficient(term, squared[t], rate);
    if (term == NoiseTerm::white) noise.angle_random_walk = value;
    if (term == NoiseTerm::flicker) noise.bias_instability = value;
    if (term == NoiseTerm::markov) {
      noise.markov_sd = value;
      noise.markov_time = terms[t].unit.markov_time / rate;
    }
    if (term == NoiseTerm::random_walk) noise.rate_random_walk = value;
  }
  // Averages need some white noise: quantization, taken as independent from one to the next, is at least what it does.
  if (noise.angle_random_walk == 0.0)
    for (std::size_t t = 0; t < terms.size(); ++t)
      if (terms[t].unit.term == NoiseTerm::quantization)
        noise.angle_random_walk = std::sqrt(2.0 * squared[t] / interval) / rate;
  return noise;
}

}  // namespace

Ramp estimate_ramp(std::span<const double> values, double rate, const AllanFit& fit) {
  const RampAverages averages = averages_of(values, rate);
  // A walk too weak for the Allan variance still moves the slope.
  auto squared = fit.squared;
  for (std::size_t t = 0; t < squared.size(); ++t)
    if (fit.terms[t].unit.term == NoiseTerm::random_walk && !fit.terms[t].kept) squared[t] = fit.terms[t].upper_limit;
  const Line best = regress(averages, noise_of(fit.terms, squared, rate, averages.interval));
  // Relative variance of the slope's variance by what is not known of each term.
  std::vector<double> derivative(fit.squared.size(), 0.0);
  for (std::size_t t = 0; t < derivative.size(); ++t) {
    if (squared[t] == 0.0 || fit.terms[t].unit.term == NoiseTerm::quantization) continue;
    auto more = squared;
    more[t] *= 1.1;
    const double moved = regress(averages, noise_of(fit.terms, more, rate, averages.interval)).variance;
    derivative[t] = (moved / best.variance - 1.0) / (0.1 * squared[t]);
  }
  double relative = 0.0;
  for (std::size_t a = 0; a < derivative.size(); ++a)
    for (std::size_t b = 0; b < derivative.size(); ++b)
      relative += derivative[a] * fit.covariance(a, b) * derivative[b];
  Ramp ramp;
  ramp.slope = best.slope;
  ramp.sd = std::sqrt(best.variance);
  ramp.taken = regress(averages, noise_of(fit.terms, fit.squared, rate, averages.interval)).variance;
  ramp.degrees_of_freedom = std::clamp(2.0 / std::max(relative, 1e-9), 1.0, most_freedom);
  ramp.chance = 2.0 * boost::math::cdf(boost::math::complement(boost::math::students_t(ramp.degrees_of_freedom),
                                                               std::abs(ramp.slope) / ramp.sd));
  return ramp;
}

std::vector<AllanObservation> without_ramp(std::vector<AllanObservation> observations, double rate, const Ramp& ramp) {
  for (auto& one : observations) {
    const double tau = static_cast<double>(one.factor) / rate;
    one.variance += 0.5 * tau * tau * ramp.taken;
  }
  return observations;
}

std::vector<double> levelled(std::span<const double> values, double rate, double slope) {
  std::vector<double> level(values.begin(), values.end());
  const double middle = 0.5 * static_cast<double>(values.size() - 1);
  for (std::size_t i = 0; i < level.size(); ++i) level[i] -= slope * (static_cast<double>(i) - middle) / rate;
  return level;
}

}  // namespace tumble::allan_noise
