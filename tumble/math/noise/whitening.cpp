#include "tumble/math/noise/whitening.hpp"

#include <cmath>

namespace tumble {

namespace {

constexpr double cancels_below = 1e-2;  ///< [correlation times] of an interval: the series is exact to 1e-7 there

}  // namespace

/// Averages of a Markov process over an interval D, T its correlation time, phi = exp(-D/T), variance s^2:
///   seen = (T/D)(1-phi), var w = s^2 (1-phi^2), cov(w,e) = s^2 (T/D)(1-phi)^2,
///   var e = 2 s^2 (T/D)^2 [D - 2T(1-phi) + T(1-phi^2)/2]/T
Whitening::State Whitening::markov(const MarkovComponent& component, double interval) {
  const double s2 = component.sd * component.sd, ratio = interval / component.time;
  const double fall = -std::expm1(-ratio);  // 1 - phi
  double inside;
  if (ratio < cancels_below) {  // the bracket cancels: its Taylor series, next term 7/60 ratio^3 relative
    inside = s2 * 2.0 / 3.0 * ratio * (1.0 - 0.75 * ratio + 0.35 * ratio * ratio);
  } else {
    inside = 2.0 * s2 / (ratio * ratio) * (ratio - 2.0 * fall + 0.5 * fall * (2.0 - fall));
  }
  return {1.0 - fall, fall / ratio, s2 * fall * (2.0 - fall), inside, s2 * fall * fall / ratio, s2};
}

/// Averages of a random walk: var w = K^2 D, var e = K^2 D/3, cov(w,e) = K^2 D/2.
Whitening::State Whitening::walk(double density, double interval) {
  const double step = density * density * interval;
  return {1.0, 1.0, step, step / 3.0, step / 2.0, 0.0};
}

Whitening::Whitening(const NoiseModel& noise, double interval, double longest)
    : white_(noise.angle_random_walk * noise.angle_random_walk / interval) {
  if (noise.bias_instability > 0.0)
    for (const auto& component : flicker_bank(noise.bias_instability, interval, longest))
      states_.push_back(markov(component, interval));
  if (noise.markov_sd > 0.0) states_.push_back(markov({noise.markov_sd, noise.markov_time}, interval));
  if (noise.rate_random_walk > 0.0) states_.push_back(walk(noise.rate_random_walk, interval));
}

Whitening::Gains Whitening::gains_for(std::span<const double> share) const {
  const std::size_t n = share.size(), s = states_.size();
  double inside = 0.0;
  for (const auto& state : states_) inside += state.inside;
  std::vector<double> p(s * s, 0.0), gain(s), seen(s);
  for (std::size_t i = 0; i < s; ++i) p[i * s + i] = states_[i].variance;
  Gains out{std::vector<double>(n, 0.0), std::vector<double>(n * s, 0.0)};
  for (std::size_t k = 0; k < n; ++k) {
    const bool data = share[k] > 0.0;
    double f = data ? white_ / share[k] + inside : 0.0;
    for (std::size_t i = 0; i < s; ++i) {
      seen[i] = 0.0;
      for (std::size_t j = 0; j < s; ++j) seen[i] += p[i * s + j] * states_[j].seen;
      if (data) f += states_[i].seen * seen[i];
    }
    if (data) {
      out.scale[k] = 1.0 / std::sqrt(f);
      out.log_determinant += std::log(f);
      for (std::size_t i = 0; i < s; ++i)
        out.of_state[k * s + i] = gain[i] = (states_[i].keep * seen[i] + states_[i].cross) / f;
    }
    for (std::size_t i = 0; i < s; ++i)
      for (std::size_t j = 0; j < s; ++j) {
        double next = states_[i].keep * p[i * s + j] * states_[j].keep + (i == j ? states_[i].drive : 0.0);
        if (data) next -= gain[i] * f * gain[j];
        p[i * s + j] = next;
      }
  }
  return out;
}

double Whitening::operator()(Matrix& block, std::span<const double> share) const {
  const std::size_t n = block.rows, s = states_.size();
  const auto [scale, gains, log_determinant] = gains_for(share.first(n));
  for (std::size_t column = 0; column < block.columns; ++column) {
    double* y = block.values.data() + column * n;
    std::vector<double> state(s, 0.0);
    for (std::size_t k = 0; k < n; ++k) {
      double innovation = 0.0;
      if (scale[k] > 0.0) {
        innovation = y[k];
        for (std::size_t i = 0; i < s; ++i) innovation -= states_[i].seen * state[i];
      }
      for (std::size_t i = 0; i < s; ++i) state[i] = states_[i].keep * state[i] + gains[k * s + i] * innovation;
      y[k] = innovation * scale[k];
    }
  }
  return log_determinant;
}

}  // namespace tumble
