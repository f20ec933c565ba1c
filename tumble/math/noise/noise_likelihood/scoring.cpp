#include "tumble/math/noise/noise_likelihood/scoring.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"

namespace tumble::noise_likelihood {
namespace {

constexpr double rising = 1e-9;     ///< [1] gradient in unit columns, by which a coefficient that is zero may rise
constexpr double not_worse = 1e-9;  ///< of -2 ln L: rounding
constexpr int most_rounds = 60, most_halvings = 12;

constexpr double accuracy = 1e-9;  ///< of -2 ln L: 3e-5 of the standard uncertainty of a term

/// Power over that of white noise, averaged over frequencies within a factor of 2 either way.
std::vector<double> smoothed(const BandData& data) {
  const auto white = column(data.design, 1);
  std::vector<double> s;
  for (std::size_t i = 0; i < data.z.size(); ++i) {
    double sum = 0.0, count = 0.0;
    for (std::size_t j = 0; j < data.z.size(); ++j) {
      const double ratio = data.bands[j].frequency / data.bands[i].frequency;
      if (ratio < 0.5 || ratio > 2.0) continue;
      sum += data.count[j] * data.z[j] / white[j];
      count += data.count[j];
    }
    s.push_back(sum / count * white[i]);
  }
  const double least = s.empty() ? 0.0 : 1e-12 * std::ranges::max(s);
  for (double& value : s) value = std::max(value, least);
  return s;
}

/// The terms in `free` that make 1/2 c'Gc - b'c least, zeros for the others.
std::vector<double> solve_for(const std::vector<bool>& free, const Matrix& gram, std::span<const double> right) {
  std::vector<std::size_t> list;
  std::vector<double> chosen, c(free.size());
  for (std::size_t t = 0; t < free.size(); ++t)
    if (free[t]) list.push_back(t), chosen.push_back(right[t]);
  const auto solved = solve_symmetric(chosen_rows(chosen_columns(gram, list), list), chosen);
  for (std::size_t k = 0; k < list.size(); ++k) c[list[k]] = solved[k];
  return c;
}

/// min 1/2 c'Gc - b'c for c >= 0: terms leave while they are negative and return while that pays.
std::vector<double> nonnegative(const Matrix& gram, std::span<const double> right) {
  const std::size_t p = right.size();
  std::vector<bool> free(p, true);
  std::vector<double> c(p);
  for (std::size_t round = 0; round < 4 * p + 4; ++round) {
    c = solve_for(free, gram, right);
    const auto worst = std::ranges::min_element(c);
    if (p > 0 && *worst < 0.0) {
      free[static_cast<std::size_t>(worst - c.begin())] = false;
      continue;
    }
    const auto gradient = difference(right, gram * c);
    std::size_t best = p;
    for (std::size_t t = 0; t < p; ++t)
      if (!free[t] && gradient[t] > rising && (best == p || gradient[t] > gradient[best])) best = t;
    if (best == p) break;
    free[best] = true;
  }
  for (double& value : c) value = std::max(value, 0.0);
  return c;
}

/// Mean squares of x - slope a.
double about_ramp(const BandData& data, double slope, std::size_t i) {
  return data.z[i] - 2.0 * slope * data.with_ramp[i] + slope * slope * data.ramp_square[i];
}

/// r - 1 - ln r: what a band with mean square z adds to -2 ln L at r = z/s, beyond its least value at s = z.
double deviance(double r) {
  const double beyond = r - 1.0;
  return beyond - (std::abs(beyond) < 0.5 ? std::log1p(beyond) : std::log(r));
}

/// -2 ln L less sum_b count_b (1 + ln z_b), which no model changes: of 10^9 samples that sum is rounded to 1e-6, what
/// remains to 1e-11.
double minus_twice(const BandData& data, std::span<const double> s, bool ramp, RampFit& fitted) {
  if (ramp) fitted = fit_ramp(data, s);
  double sum = ramp ? -std::log(fitted.variance) : 0.0;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const double z = data.z[i], off_ramp = ramp ? (about_ramp(data, fitted.slope, i) - z) / s[i] : 0.0;
    sum += data.count[i] * ((z > 0.0 ? deviance(z / s[i]) : std::log(s[i])) + off_ramp);
  }
  return sum;
}

/// Mean squares that the terms are to explain: without what is known, the uncertainty of the ramp counted.
std::vector<double> rest_of(const BandData& data, bool ramp, const RampFit& line, std::span<const double> known) {
  std::vector<double> rest = data.z;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (ramp) rest[i] = about_ramp(data, line.slope, i) + line.variance * data.ramp_square[i];
    if (!known.empty()) rest[i] -= known[i];
  }
  return rest;
}

std::vector<double> step(const BandData& data, const Matrix& x, std::span<const double> rest,
                         std::span<const double> s) {
  const auto weight = root_weights(data, s);
  Matrix weighted = scaled_rows(weight, x);
  const auto scale = inverses(column_norms(weighted));
  weighted = scaled_columns(std::move(weighted), scale);
  return scaled(scale, nonnegative(gram(weighted), transposed_product(weighted, scaled(weight, rest))));
}

}  // namespace

BandData::BandData(const NoiseBands& from)
    : design(from.bands.size(), power_law_terms.size()), bands(from.bands), scatter(from.scatter) {
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const NoiseBand& band = bands[i];
    z.push_back(band.mean_square);
    count.push_back(band.count);
    with_ramp.push_back(band.with_ramp);
    ramp_square.push_back(band.ramp_square);
    slow.push_back(band.radix == 0 ? 1.0 : 0.0);
    for (std::size_t t = 0; t < design.columns; ++t) design(i, t) = band.expected[t];
  }
  start = smoothed(*this);
}

std::vector<double> BandData::markov(double time) const {
  std::vector<double> expected;
  for (const NoiseBand& band : bands) expected.push_back(expected_markov(band, time));
  return expected;
}

std::vector<double> BandData::filtered(const NoiseFilter& filter) const { return expected_filtered(bands, filter); }

std::vector<double> root_weights(const BandData& data, std::span<const double> s) {
  std::vector<double> weights;
  weights.reserve(s.size());
  for (std::size_t i = 0; i < s.size(); ++i) weights.push_back(std::sqrt(0.5 * data.count[i]) / s[i]);
  return weights;
}

RampFit fit_ramp(const BandData& data, std::span<const double> s) {
  double squares = 0.0, products = 0.0;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const double weight = data.slow[i] * data.count[i] / s[i];
    squares += weight * data.ramp_square[i];
    products += weight * data.with_ramp[i];
  }
  if (!(squares > 0.0)) return {0.0, INFINITY};
  return {products / squares, 1.0 / squares};
}

ScoringFit fit_by_scoring(const BandData& data, const Matrix& x, bool ramp, const std::vector<double>& start,
                          std::span<const double> known) {
  ScoringFit fit{std::vector<double>(x.columns), start};
  RampFit line;
  fit.minus_twice_log_likelihood = minus_twice(data, fit.s, ramp, line);
  bool placed = false;  // whether s is that of c
  for (int iteration = 0; iteration < most_rounds; ++iteration) {
    const auto to = step(data, x, rest_of(data, ramp, line, known), fit.s);
    double share = 1.0, likelihood = 0.0;
    std::vector<double> c, s;
    RampFit moved;
    for (int halving = 0; halving < most_halvings; ++halving, share *= 0.5) {
      c = placed ? scaled_sum(fit.c, share, difference(to, fit.c)) : to;
      s = known.empty() ? x * c : scaled_sum(x * c, 1.0, known);
      likelihood = std::ranges::min(s) > 0.0 ? minus_twice(data, s, ramp, moved) : INFINITY;
      if (!placed || likelihood <= fit.minus_twice_log_likelihood + not_worse) break;
    }
    const double fall = fit.minus_twice_log_likelihood - likelihood;
    if (placed && !(fall > -not_worse)) break;
    const bool settled = placed && fall < accuracy;
    for (double& value : s) value = std::max(value, 1e-300);
    fit.c = std::move(c);
    fit.s = std::move(s);
    fit.minus_twice_log_likelihood = likelihood;
    line = moved;
    placed = true;
    if (settled) break;
  }
  if (!ramp) return fit;
  const auto [slope, variance] = fit_ramp(data, fit.s);
  fit.slope = slope;
  fit.slope_variance = variance;
  return fit;
}

}  // namespace tumble::noise_likelihood
