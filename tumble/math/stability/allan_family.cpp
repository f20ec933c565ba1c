#include "tumble/math/stability/allan_family.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/stability/allan_differences.hpp"
#include "tumble/math/stability/allan_edf.hpp"
#include "tumble/math/stability/allan_edf_extended.hpp"
#include "tumble/math/stability/allan_noise_type.hpp"
#include "tumble/math/stability/allan_phase.hpp"
#include "tumble/math/stability/allan_sums.hpp"
#include "tumble/math/stability/allan_theoh.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double least_ratio_of_total = 2.0;  ///< [averaging times] of a run
constexpr std::size_t fewest_of_total = 16;   ///< samples of a run
constexpr std::size_t typed_part = 31;        ///< of the record: longer averaging times have too few values for a type

/// The measure in units of t0 = 1: variance, or for interval errors the square of the answer.
/// theo_bias: of ThêoH, Allan over Theo1 variance.
MeanSquare measure_at(Stability measure, std::span<const double> x, std::span<const double> rate, double theo_bias,
                      std::size_t m) {
  const double square = static_cast<double>(m) * static_cast<double>(m);
  switch (measure) {
    case Stability::allan:
      return difference_variance(x, m, 2, m);
    case Stability::overlapping_allan:
      return difference_variance(x, m, 2, 1);
    case Stability::hadamard:
      return difference_variance(x, m, 3, m);
    case Stability::overlapping_hadamard:
      return difference_variance(x, m, 3, 1);
    case Stability::modified_allan:
    case Stability::time:
      return modified_allan_variance(x, m);
    case Stability::parabolic:
      return parabolic_variance(x, m);
    case Stability::total:
      return total_variance(x, m);
    case Stability::modified_total:
    case Stability::time_total: {
      const auto mean = reflected_segments(x, m);
      return {mean.value / (2.0 * square), mean.count};
    }
    case Stability::hadamard_total: {
      if (m == 1) return difference_variance(x, m, 3, 1);  // as published: there is nothing to average
      const auto mean = reflected_segments(rate, m);
      return {mean.value / 6.0, mean.count};
    }
    case Stability::theo1:
      return theo1_variance(x, m);
    case Stability::theoh:
      return theoh_variance(x, theo_bias, m);
    case Stability::peak_interval_error: {
      const auto peak = peak_interval_error(x, m);
      return {peak.value * peak.value, peak.count};
    }
    case Stability::rms_interval_error:
      return interval_error_variance(x, m);
  }
  return {};
}

bool is_interval_error(Stability measure) {
  return measure == Stability::peak_interval_error || measure == Stability::rms_interval_error;
}

/// From the square in samples to the deviation: [u], or [u s] of those that are times.
double deviation_of(Stability measure, double square, double tau, double interval) {
  if (is_interval_error(measure)) return std::sqrt(square);
  const double deviation = std::sqrt(square) / interval;
  return measure == Stability::time || measure == Stability::time_total ? tau * deviation / std::sqrt(3.0) : deviation;
}

/// Expected variance of a measure over that of the one it stands for; records of T/tau = `ratio`.
double bias(Stability measure, int alpha, std::size_t m, double ratio) {
  switch (measure) {
    case Stability::total:
      return total_bias(alpha, m, ratio);
    case Stability::modified_total:
    case Stability::time_total:
      return modified_total_bias(alpha, m);
    case Stability::hadamard_total:
      return m == 1 ? 1.0 : hadamard_total_bias(alpha, m);  // it is the Hadamard deviation there
    default:
      return 1.0;
  }
}

/// edf of the measure with `count` terms at factor m of a run of `points` phase points; 0 where none is known.
double edf_of(Stability measure, int alpha, std::size_t m, std::size_t count, std::size_t points) {
  const double ratio = static_cast<double>(points - 1) / static_cast<double>(m);
  switch (measure) {
    case Stability::allan:
      return phase_difference_edf(alpha, {2, false, false}, m, count);
    case Stability::overlapping_allan:
      return phase_difference_edf(alpha, {2, true, false}, m, count);
    case Stability::modified_allan:
    case Stability::time:
      return phase_difference_edf(alpha, {2, true, true}, m, count);
    case Stability::hadamard:
      return phase_difference_edf(alpha, {3, false, false}, m, count);
    case Stability::overlapping_hadamard:
      return phase_difference_edf(alpha, {3, true, false}, m, count);
    case Stability::total:
      return total_edf(alpha, m, ratio);
    case Stability::modified_total:
    case Stability::time_total:
      return modified_total_edf(alpha, m, ratio);
    case Stability::hadamard_total:
      return hadamard_total_edf(alpha, m, ratio);
    case Stability::parabolic:
      return parabolic_edf(alpha, m, count);
    case Stability::theo1:
      return theo1_edf(alpha, m, points);
    case Stability::theoh:
      return ratio >= theoh_shortest_ratio ? phase_difference_edf(alpha, {2, true, false}, m, count)
                                           : theo_bias_removed_edf(alpha, m, points);
    case Stability::rms_interval_error:  // slower noise has none: its mean square depends on the record's length
      return alpha > 0 ? phase_difference_edf(alpha, {1, true, false}, m, count) : 0.0;
    case Stability::peak_interval_error:
      return 0.0;
  }
  return 0.0;
}

void check(double interval, std::span<const std::size_t> factors, const StabilityOptions& options) {
  Problems problems;
  if (!(interval > 0.0 && std::isfinite(interval)))
    problems.push_back("interval between phase points must be above 0 s");
  if (!(options.confidence > 0.0 && options.confidence < 1.0))
    problems.push_back("confidence must lie between 0 and 1");
  if (!std::is_sorted(factors.begin(), factors.end()) || (!factors.empty() && factors.front() == 0)) {
    problems.push_back("averaging factors must be whole numbers from 1 on, in ascending order");
  }
  if (!options.types.empty() && options.types.size() != factors.size())
    problems.push_back("noise types are one for each averaging factor");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// What the runs between gaps say together: estimates weighted by their number of terms, of peaks the largest. Runs are
/// nearly independent: edf = M^2/sum(M_i^2/edf_i); 0 where no formula is published.
struct Pooled {
  double square = 0.0;
  std::size_t count = 0;
  double edf = 0.0;
};

Pooled pool(Stability measure, const Phase& phase, std::span<const double> theo_bias, std::size_t m, int alpha,
            bool remove_bias) {
  Pooled pooled;
  double sum = 0.0, spread = 0.0;
  bool known = true;
  for (std::size_t r = 0; r < phase.runs.size(); ++r) {
    const auto x = phase.values.subspan(phase.runs[r].first, phase.runs[r].points());
    std::vector<double> rate;
    if (measure == Stability::hadamard_total) {
      for (std::size_t n = 0; n + 1 < x.size(); ++n) rate.push_back(x[n + 1] - x[n]);
    }
    const auto found = measure_at(measure, x, rate, theo_bias[r], m);
    if (found.count == 0) continue;
    const double ratio = static_cast<double>(x.size() - 1) / static_cast<double>(m);
    // Short runs are hardly more than their mirror images.
    if (measure == Stability::total && phase.runs.size() > 1 &&
        (ratio < least_ratio_of_total || x.size() < fewest_of_total))
      continue;
    double value = remove_bias ? found.value / bias(measure, alpha, m, ratio) : found.value;
    if (measure == Stability::theoh && remove_bias && ratio < theoh_shortest_ratio)
      value *= theo_ratio_change(alpha, x.size(), m);
    const double terms = static_cast<double>(found.count), edf = edf_of(measure, alpha, m, found.count, x.size());
    pooled.count += found.count;
    pooled.square = std::max(pooled.square, value);
    sum += terms * value;
    known = known && edf > 0.0;
    spread += known ? terms * terms / edf : 0.0;
  }
  if (pooled.count == 0) return pooled;
  const double all = static_cast<double>(pooled.count);
  if (measure != Stability::peak_interval_error) pooled.square = sum / all;
  pooled.edf = known ? all * all / spread : 0.0;
  return pooled;
}

/// Noise type at each factor. That of ThêoH is the one of the longest tau whose 30 strided points tell it well.
std::vector<int> types_of(Stability measure, const Phase& phase, std::span<const std::size_t> factors,
                          const StabilityOptions& options) {
  if (!options.types.empty()) return options.types;
  if (options.alpha) return std::vector<int>(factors.size(), *options.alpha);
  std::vector<std::size_t> typed(factors.begin(), factors.end());
  if (measure == Stability::theoh)
    for (std::size_t& m : typed) m = std::min(m, std::max<std::size_t>(1, phase.values.size() / typed_part));
  return identify_noise_types(phase, typed);
}

}  // namespace

std::vector<DeviationPoint> stability(Stability measure, std::span<const double> phase, double interval,
                                      std::span<const std::size_t> factors, const StabilityOptions& options) {
  check(interval, factors, options);
  const auto bad = std::find_if(phase.begin(), phase.end(), [](double value) { return !std::isfinite(value); });
  if (bad != phase.end()) {
    throw Error(Error::Kind::bad_data, say("phase point {} is not a finite number", bad - phase.begin()));
  }
  if (phase.size() < 2) return {};
  return stability_of_runs(measure, {phase, {{0, phase.size() - 1}}, nullptr}, interval, factors, options);
}

std::vector<DeviationPoint> stability_of_rate(Stability measure, std::span<const double> rate, double interval,
                                              std::span<const std::size_t> factors, const StabilityOptions& options) {
  check(interval, factors, options);
  const auto phase = integrate_rate(rate, 1);
  const auto values = scaled(interval, phase.values);
  return stability_of_runs(measure, {values, phase.runs, nullptr}, interval, factors, options);
}

std::vector<DeviationPoint> stability_of_runs(Stability measure, const Phase& phase, double interval,
                                              std::span<const std::size_t> factors, const StabilityOptions& options) {
  check(interval, factors, options);
  std::vector<DeviationPoint> points;
  std::vector<double> theo_bias(phase.runs.size(), 1.0);
  for (std::size_t r = 0; measure == Stability::theoh && r < phase.runs.size(); ++r)
    theo_bias[r] = allan_over_theo1(phase.values.subspan(phase.runs[r].first, phase.runs[r].points()));
  const auto types = types_of(measure, phase, factors, options);
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const std::size_t m = factors[i];
    const auto pooled = pool(measure, phase, theo_bias, m, types[i], options.remove_bias);
    if (pooled.count == 0) continue;
    const double scale = measure == Stability::theo1 ? 0.75 : 1.0;
    DeviationPoint point{.factor = m, .tau = scale * static_cast<double>(m) * interval, .count = pooled.count};
    point.alpha = types[i];
    point.deviation = deviation_of(measure, pooled.square, point.tau, interval);
    point.edf = pooled.edf;
    const auto limits = point.edf > 0.0 ? deviation_limits(point.deviation, point.edf, options.confidence)
                                        : Limits{point.deviation, point.deviation};
    point.lower = limits.lower;
    point.upper = limits.upper;
    points.push_back(point);
  }
  return points;
}

std::vector<double> phase_from_rate(std::span<const double> rate, double interval) {
  const auto phase = integrate_rate(rate, 1);
  if (phase.has_gaps()) throw Error(Error::Kind::bad_data, "the rate has missing samples: use stability_of_rate");
  return scaled(interval, phase.values);
}

}  // namespace tumble
