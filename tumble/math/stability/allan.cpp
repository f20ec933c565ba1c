#include "tumble/math/stability/allan.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/stability/allan_differences.hpp"
#include "tumble/math/stability/allan_edf.hpp"
#include "tumble/math/stability/allan_noise_type.hpp"
#include "tumble/math/stability/allan_phase.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

void check(double sample_rate, const AllanOptions& options) {
  Problems problems;
  if (!(sample_rate > 0.0 && std::isfinite(sample_rate))) problems.push_back("sample rate must be above 0 Hz");
  if (!(options.points_per_decade >= 0.0 && std::isfinite(options.points_per_decade))) {
    problems.push_back("points per decade must be 0 (octaves) or more");
  }
  if (!(options.confidence > 0.0 && options.confidence < 1.0))
    problems.push_back("confidence must lie between 0 and 1");
  if (!(options.longest_fraction > 0.0 && options.longest_fraction <= 0.5)) {
    problems.push_back("longest fraction of the record must be above 0 and at most 0.5");
  }
  const auto& factors = options.factors;
  if (!std::is_sorted(factors.begin(), factors.end()) || (!factors.empty() && factors.front() == 0))
    problems.push_back("averaging factors must be whole numbers from 1 on, in ascending order");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// Terms of each run that has any.
std::vector<std::size_t> terms_of_runs(const Phase& phase, std::size_t factor) {
  std::vector<std::size_t> terms;
  for (const auto& run : phase.runs) {
    if (run.points() > 2 * factor) terms.push_back(run.points() - 2 * factor);
  }
  return terms;
}

/// Runs between gaps give nearly independent estimates, pooled by their number of terms: edf = M^2/sum(M_i^2/edf_i).
double pooled_edf(const std::vector<std::size_t>& terms, int alpha, std::size_t factor) {
  std::map<std::size_t, std::size_t> runs_of_length;
  for (const std::size_t count : terms) ++runs_of_length[count];
  double all = 0.0, weighted = 0.0;
  for (const auto& [count, runs] : runs_of_length) {
    const double M = static_cast<double>(count);
    all += M * static_cast<double>(runs);
    weighted += M * M * static_cast<double>(runs) / phase_difference_edf(alpha, PhaseDifference{}, factor, count);
  }
  return all * all / weighted;
}

/// A point for each factor that has a term.
std::vector<DeviationPoint> points_of(const Phase& phase, double sample_rate, std::span<const std::size_t> factors,
                                      double confidence, std::span<const int> alphas) {
  const auto sums = second_difference_sums(phase, factors);
  const auto types = alphas.empty() ? identify_noise_types(phase, factors) : std::vector(alphas.begin(), alphas.end());
  std::vector<DeviationPoint> points;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const auto terms = terms_of_runs(phase, factors[i]);
    if (terms.empty()) continue;
    DeviationPoint point{.factor = factors[i], .tau = static_cast<double>(factors[i]) / sample_rate};
    for (const std::size_t count : terms) point.count += count;
    const double m = static_cast<double>(factors[i]);
    if (!std::isfinite(sums[i]))
      throw Error(Error::Kind::bad_data, "the values are too large to be squared and summed: check their unit");
    point.deviation = std::sqrt(sums[i] / (2.0 * static_cast<double>(point.count))) / m;
    point.alpha = types[i];
    point.edf = pooled_edf(terms, types[i], factors[i]);
    const auto limits = deviation_limits(point.deviation, point.edf, confidence);
    point.lower = limits.lower;
    point.upper = limits.upper;
    points.push_back(point);
  }
  return points;
}

}  // namespace

std::vector<std::size_t> averaging_factors(std::size_t longest, double points_per_decade) {
  const long steps = std::max(1L, std::lround(points_per_decade * std::log10(2.0)));  // an octave
  const std::size_t first = std::max<std::size_t>(16, std::bit_ceil(static_cast<std::size_t>(steps)));
  std::vector<std::size_t> factors;
  for (std::size_t octave = 1; octave <= longest; octave *= 2) {
    const std::size_t rounded = std::min(octave, first);
    for (long k = 0; k < steps; ++k) {
      const double exact =
          static_cast<double>(rounded) * std::exp2(static_cast<double>(k) / static_cast<double>(steps));
      const std::size_t factor = static_cast<std::size_t>(std::llround(exact)) * (octave / rounded);
      if (factor <= longest && (factors.empty() || factor > factors.back())) factors.push_back(factor);
    }
  }
  return factors;
}

Limits deviation_limits(double deviation, double edf, double confidence) {
  const double tail = 0.5 * (1.0 - confidence);
  return {deviation * std::sqrt(edf / chi_square_quantile(1.0 - tail, edf)),
          deviation * std::sqrt(edf / chi_square_quantile(tail, edf))};
}

std::vector<DeviationPoint> overlapping_allan(std::span<const double> rate, double sample_rate,
                                              const AllanOptions& options) {
  check(sample_rate, options);
  const Phase phase = integrate_rate_once(rate, 3);
  const double longest = std::max(1.0, std::floor(options.longest_fraction * static_cast<double>(rate.size())));
  const auto factors = options.factors.empty()
                           ? averaging_factors(static_cast<std::size_t>(longest), options.points_per_decade)
                           : options.factors;
  return points_of(phase, sample_rate, factors, options.confidence, {});
}

std::vector<DeviationPoint> overlapping_allan(std::span<const double> rate, double sample_rate,
                                              std::span<const std::size_t> factors, double confidence,
                                              std::span<const int> alphas) {
  check(sample_rate, {.confidence = confidence, .factors = {factors.begin(), factors.end()}});
  return points_of(integrate_rate_once(rate, 1), sample_rate, factors, confidence, alphas);
}

}  // namespace tumble
