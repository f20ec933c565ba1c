#include "tumble/methods/rlg_lock_in/dead_band.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tumble/math/regression/least_squares.hpp"
#include "tumble/models/lock_in.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rlg_lock_in {
namespace {

constexpr double fast_share = 0.3;        ///< [1] of the fastest rate, from which on a point gives a first scale factor
constexpr double clear_of_lock = 0.3;     ///< [1] of the beat without lock-in: from 1.05 times the edge on
constexpr double most_spread = 0.02;      ///< [1] of the distance to the edge, that the rate of a point may vary by
constexpr double settled_within = 1e-10;  ///< [1] of the parameters, by which the last round moves them
constexpr std::size_t parts_of_segment = 8, least_of_part = 2;  ///< whose means show the noise; samples of a part
constexpr double clear_of_edge = 1.5;  ///< [1] of the lock-in rate: slower beats go so unevenly that parts differ by it
/// [1] of the variance between the parts, that is noise and not counting: with less it is not known to a factor of two.
constexpr double least_beside_counting = 0.1;
constexpr double band_shown_sd = 3.0;  ///< [sd] of the lock-in rate, below which there is no dead band

[[noreturn]] void refuse(const Sentence& why) { throw Error(Error::Kind::bad_data, why); }

constexpr const char* no_dead_band =
    "the beats are proportional to the rates and show no dead band; add rates nearer to it, or say that the dither was "
    "on (dither = \"on\")";

bool any_undithered(const Sweep& sweep) {
  return std::ranges::any_of(sweep.points, [](const Point& point) { return !point.dithered; });
}

std::size_t least_points(bool locked) { return locked ? 5 : 4; }

/// The points that the fit may look at: those without dither, or all.
std::vector<std::size_t> candidates(const Sweep& sweep, bool locked) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < sweep.points.size(); ++i)
    if (!locked || !sweep.points[i].dithered) out.push_back(i);
  return out;
}

/// Both senses of rotation, and points enough.
void refuse_too_few(const Sweep& sweep, const std::vector<std::size_t>& chosen, bool locked, double bias) {
  std::size_t positive = 0;
  for (const std::size_t i : chosen) positive += sweep.points[i].rate + bias > 0.0 ? 1 : 0;
  if (chosen.size() >= least_points(locked) && positive >= 2 && chosen.size() - positive >= 2) return;
  refuse(
      say("{} rates that show the scale factor, {} of them positive: needed are {} or more{}, two or more of "
          "each sign",
          chosen.size(), positive, least_points(locked), locked ? " outside of the dead band" : ""));
}

/// K by the steepest of the beats at fast rates, with the sense in which the gyro counts: outside of a dead band no
/// beat is steeper than K.
void start_slope(const Sweep& sweep, const std::vector<std::size_t>& among, DeadBand& band) {
  double fastest = 0.0, slope = 0.0, against = 0.0;
  for (const std::size_t i : among) fastest = std::max(fastest, std::abs(sweep.points[i].rate));
  for (const std::size_t i : among) {
    const Point& point = sweep.points[i];
    if (std::abs(point.rate) < fast_share * fastest || point.rate == 0.0) continue;
    slope = std::max(slope, point.beat / point.rate);
    against = std::max(against, -point.beat / point.rate);
  }
  if (!std::isfinite(slope) || !std::isfinite(against)) refuse("the gyro's counts are not finite numbers");
  band.sense = against > slope ? -1.0 : 1.0;
  band.scale_factor = std::max(slope, against);
  if (!(band.scale_factor > 0.0)) refuse("the gyro does not count at any rate of the sweep");
}

/// First values by w^2 = W_L^2 - b^2 + (f/K)^2 - 2 b w: (4.23) squared is linear.
void start_values(const Sweep& sweep, bool locked, DeadBand& band) {
  const auto among = candidates(sweep, locked);
  start_slope(sweep, among, band);
  if (!locked) return;
  std::vector<std::size_t> clear;
  for (const std::size_t i : among)
    if (std::abs(sweep.points[i].beat) > clear_of_lock * band.scale_factor * std::abs(sweep.points[i].rate))
      clear.push_back(i);
  refuse_too_few(sweep, clear, locked, 0.0);
  Matrix design(clear.size(), 3);
  std::vector<double> squares, weights;
  for (std::size_t k = 0; k < clear.size(); ++k) {
    const Point& point = sweep.points[clear[k]];
    design(k, 0) = 1.0;
    design(k, 1) = point.beat * point.beat;
    design(k, 2) = point.rate;
    squares.push_back(point.rate * point.rate);
    weights.push_back(point.duration / (squares.back() + 1e-300));
  }
  const auto fit = least_squares(design, squares, weights, {.names = {"W_L^2", "1/K^2", "b"}});
  const double b = -0.5 * fit.parameters[2], square = fit.parameters[0] + b * b;
  if (!fit.unobservable.empty() || !(fit.parameters[1] > 0.0))
    refuse("the beats of the sweep do not rise with the rate as f^2 = K^2 (W^2 - W_L^2) says");
  if (!(square > 0.0)) refuse(no_dead_band);
  band.scale_factor = 1.0 / std::sqrt(fit.parameters[1]);
  band.bias = b;
  band.lock_in_rate = std::sqrt(square);
}

/// White noise [rad^2/s] that rounds the edge: as the residuals show it, but no more than the segments hold, since what
/// differs between them (a step of the bias) does not round it.
double rounding_noise(const Sweep& sweep, const DeadBandOptions& options, const DeadBand& band) {
  constexpr double beyond_sd = 3.0;
  const NoiseWithin within = noise_within(sweep, options, band);
  if (!(within.freedom > 0.0)) return band.fit.white_variance;
  return std::min(band.fit.white_variance, within.variance * (1.0 + beyond_sd * std::sqrt(2.0 / within.freedom)));
}

/// Share of W_L within which the mean beat is not (4.23): as stated, or eight times the width over which white noise
/// rounds the edge.
double margin_of(const Sweep& sweep, const DeadBandOptions& options, const DeadBand& band) {
  constexpr double widths = 8.0, most = 0.5;
  if (!(band.lock_in_rate > 0.0)) return options.margin;
  const double diffusion = pi * band.scale_factor * rounding_noise(sweep, options, band);
  const double width = std::cbrt(band.lock_in_rate * diffusion * diffusion);
  return std::max(options.margin, std::min(most, widths * width / band.lock_in_rate));
}

/// Which points lie outside, by the nominal rate.
void choose(const Sweep& sweep, const DeadBandOptions& options, bool locked, DeadBand& band) {
  const double margin = margin_of(sweep, options, band);
  band.used.assign(sweep.points.size(), false);
  band.why_not.assign(sweep.points.size(), "");
  band.rows.clear();
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const Point& point = sweep.points[i];
    const double off = std::abs(point.rate + band.bias) - band.lock_in_rate;
    if (locked && point.dithered)
      band.why_not[i] = "dithered";
    else if (locked && off < -margin * band.lock_in_rate)
      band.why_not[i] = "in the dead band";
    else if (locked && off < margin * band.lock_in_rate)
      band.why_not[i] = "at the edge";
    else if (locked && point.spread > most_spread * off)
      band.why_not[i] = "rate not constant";
    else
      band.used[i] = true;
    if (band.used[i]) band.rows.push_back(i);
  }
}

/// Variance of the fitted rate by white noise of the input over that of the input's own mean: 1 + W_L^2/(2 W^2). The
/// phase moves unevenly near the edge, most of the time where W_L sin(psi) almost stops it, and noise acts there.
double noise_gain(const DeadBand& band, double rate) {
  const double share = band.lock_in_rate / (rate + band.bias);
  return 1.0 + 0.5 * share * share;
}

/// The rate by (4.23), linear about the values in `band`: columns 1/K, b, W_L. It is homogeneous of first order in
/// them, so that the observations stay as they are. Given: beats in the sense of the rate [fringe/s].
MixedData linearised(const Sweep& sweep, const DeadBandOptions& options, bool locked, const DeadBand& band,
                     const std::vector<double>& beats) {
  const std::size_t n = band.rows.size();
  const double g = 1.0 / band.scale_factor;
  MixedData data;
  data.design = Matrix(n, locked ? 3 : 2);
  KnownEffect counts{"count quantisation", std::vector<double>(n), true};
  for (std::size_t k = 0; k < n; ++k) {
    const Point& point = sweep.points[band.rows[k]];
    const double f = beats[band.rows[k]], root = std::hypot(g * f, band.lock_in_rate);
    const double slope = root > 0.0 ? g * f / root : 1.0;  // d root/d(g |f|), with the sign of f
    data.design(k, 0) = slope * std::abs(f);
    data.design(k, 1) = -1.0;
    if (locked) data.design(k, 2) = std::copysign(band.lock_in_rate / root, f);
    data.observations.push_back(point.rate);
    data.weights.push_back(point.duration / noise_gain(band, point.rate));
    data.segment.push_back(k);
    // a difference of two counter readings: 1/6 count^2
    counts.column[k] = std::abs(slope) * std::sqrt(pulses::rounding_variance(g, options.edges * point.duration));
  }
  data.effects.push_back(std::move(counts));
  for (std::size_t e = 0; e < sweep.effects.size(); ++e) {
    KnownEffect effect{sweep.effects[e].source, {}, sweep.effects[e].each_segment, {}, sweep.effects[e].key};
    for (const std::size_t i : band.rows) effect.column.push_back(sweep.points[i].effect[e]);
    data.effects.push_back(std::move(effect));
  }
  return data;
}

void find_residuals(const Sweep& sweep, DeadBand& band) {
  band.residual.assign(sweep.points.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const Point& point = sweep.points[i];
    if (!band.used[i] && band.why_not[i] != "rate not constant") continue;
    const double root = std::hypot(point.beat / band.scale_factor, band.lock_in_rate);
    band.residual[i] = point.rate - (std::copysign(root, band.sense * point.beat) - band.bias);
  }
}

}  // namespace

DeadBand fit_dead_band(const Sweep& sweep, const DeadBandOptions& options) {
  const bool locked = any_undithered(sweep);
  DeadBand band;
  start_values(sweep, locked, band);
  std::vector<double> beats;
  for (const auto& point : sweep.points) beats.push_back(band.sense * point.beat);
  constexpr int most = 30, choosing = 5;
  for (int round = 0; round < most; ++round) {
    if (round < choosing) choose(sweep, options, locked, band);
    refuse_too_few(sweep, band.rows, locked, band.bias);
    band.fit = fit_mixed_model(linearised(sweep, options, locked, band, beats));
    const auto& fitted = band.fit.parameters;
    const double scale = locked ? band.lock_in_rate : 1e-3;
    const double moved = std::abs(fitted[0] * band.scale_factor - 1.0) + std::abs(fitted[1] - band.bias) / scale +
                         (locked ? std::abs(fitted[2] - band.lock_in_rate) / scale : 0.0);
    band.scale_factor = 1.0 / fitted[0];
    band.bias = fitted[1];
    if (locked) band.lock_in_rate = std::abs(fitted[2]);
    if (!std::isfinite(moved) || !(band.scale_factor > 0.0))
      refuse("the beats of the sweep do not follow f^2 = K^2 (W^2 - W_L^2)");
    if (moved < settled_within) break;
  }
  if (locked && band.lock_in_rate < band_shown_sd * std::sqrt(band.fit.covariance(2, 2))) refuse(no_dead_band);
  find_residuals(sweep, band);
  return band;
}

NoiseWithin noise_within(const Sweep& sweep, const DeadBandOptions& options, const DeadBand& band) {
  double squares = 0.0, counting = 0.0, freedom = 0.0;
  for (const Point& point : sweep.points) {
    const std::size_t size = point.beats.size() / parts_of_segment;
    const double rate = std::abs(point.rate + band.bias);
    if (point.dithered || point.spread > 0.0 || rate < clear_of_edge * band.lock_in_rate || size < least_of_part)
      continue;
    const double length = static_cast<double>(size) * point.sample_step;
    const double root = std::hypot(point.beat, band.scale_factor * band.lock_in_rate);
    // d rate/d beat by (4.23), and the gain of white noise near the edge
    const double slope = root > 0.0 ? std::abs(point.beat) / root / band.scale_factor : 1.0 / band.scale_factor;
    std::vector<double> means;
    for (std::size_t k = 0; k < parts_of_segment; ++k) {
      double sum = 0.0;
      for (std::size_t i = k * size; i < (k + 1) * size; ++i) sum += point.beats[i];
      means.push_back(sum / static_cast<double>(size));
    }
    const double mean = std::accumulate(means.begin(), means.end(), 0.0) / static_cast<double>(parts_of_segment);
    if (std::isnan(mean)) continue;  // samples are missing
    const double gain = noise_gain(band, point.rate);
    for (const double one : means) squares += slope * slope * (one - mean) * (one - mean) * length / gain;
    const auto parts = static_cast<double>(parts_of_segment);
    counting +=
        slope * slope * pulses::rounding_variance(1.0, options.edges * length) * length / gain * (parts - 1.0 / parts);
    freedom += parts - 1.0;
  }
  if (!(freedom > 0.0) || !(squares > 0.0)) return {};
  const double variance = (squares - counting) / freedom;
  // the squares of sums scatter as those of normal numbers; what is subtracted does not
  const double total = squares / freedom;
  if (!(variance > least_beside_counting * total)) return {};
  return {variance, freedom * std::pow(variance / total, 2)};
}

BandRows rows_at(const Sweep& sweep, const DeadBandOptions& options, const DeadBand& band, double white_variance) {
  std::vector<double> beats;
  for (const auto& point : sweep.points) beats.push_back(band.sense * point.beat);
  MixedData data = linearised(sweep, options, band.lock_in_rate > 0.0, band, beats);
  BandRows rows{std::move(data.design), data.observations, {}};
  for (std::size_t k = 0; k < rows.rates.size(); ++k) {
    double variance = white_variance / data.weights[k];
    for (const KnownEffect& effect : data.effects)
      if (effect.each_segment) variance += effect.column[k] * effect.column[k];
    rows.variances.push_back(variance);
  }
  return rows;
}

DeadBand predict_dead_band(const Sweep& sweep, const DeadBandOptions& options, double scale_factor, double bias,
                           double lock_in_rate, double random_walk) {
  const bool locked = any_undithered(sweep);
  DeadBand band;
  band.scale_factor = scale_factor;
  band.bias = bias;
  band.lock_in_rate = locked ? lock_in_rate : 0.0;
  band.fit.white_variance = random_walk * random_walk;
  choose(sweep, options, locked, band);
  refuse_too_few(sweep, band.rows, locked, bias);
  std::vector<double> beats;
  for (const auto& point : sweep.points) beats.push_back(beat_frequency(band, point.rate));
  auto data = linearised(sweep, options, locked, band, beats);
  data.observations.clear();
  band.fit = predict_mixed_model(data, random_walk * random_walk);
  return band;
}

double beat_frequency(const DeadBand& band, double rate) {
  return band.sense * band.scale_factor *
         mean_output_rate({band.scale_factor, band.lock_in_rate}, {}, rate + band.bias);
}

}  // namespace tumble::rlg_lock_in
