#include "tumble/math/regression/lack_of_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/square.hpp"
#include "tumble/math/vector3.hpp"
#include "tumble/reduce/linear/words.hpp"
#include "tumble/reduce/linear/work.hpp"

namespace tumble::linear {
namespace {

constexpr double rare = 1e-5;  ///< chance that a sound test gives a finding, of each kind

/// The means over the segments at rest, as a regression.
struct RestingMeans {
  std::vector<std::size_t> segments;  ///< indices of the stretches
  Matrix design;                      ///< one row each
  std::vector<double> output;         ///< without the input [SI]
  std::vector<double> time;           ///< [s] since power-on, middle
  std::vector<double> duration;       ///< [s]
  Matrix effects;                     ///< of the known effects, one column each [SI]
  Matrix covariance;                  ///< [SI^2]
};

/// Row of each stretch among those at rest; none: it moves.
std::vector<std::optional<std::size_t>> rows_of_stretches(const Work& work, RestingMeans& means) {
  std::vector<std::optional<std::size_t>> row(work.solution.segments.size());
  for (std::size_t g = 0; g < row.size(); ++g) {
    if (!work.solution.segments[g].steady) continue;
    row[g] = means.segments.size();
    means.segments.push_back(g);
  }
  return row;
}

void add_covariance(const Work& work, RestingMeans& means) {
  const MixedFit& fit = work.solution.fit;
  const std::size_t n = means.segments.size();
  means.covariance = Matrix(n, n);
  for (std::size_t a = 0; a < n; ++a) {
    means.covariance(a, a) = fit.white_variance / means.duration[a];
    for (std::size_t c = 0; c < work.data.slow.size(); ++c)
      for (std::size_t b = 0; b < n; ++b)
        means.covariance(a, b) += fit.slow_variance[c] * work.data.slow[c].kernel(means.segments[a], means.segments[b]);
  }
  for (std::size_t k = 0; k < work.data.effects.size(); ++k)
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b)
        if (a == b || !work.data.effects[k].each_segment)
          means.covariance(a, b) += means.effects(a, k) * means.effects(b, k);
}

RestingMeans resting_means(const Work& work) {
  RestingMeans means;
  const auto row = rows_of_stretches(work, means);
  const std::size_t n = means.segments.size(), p = work.data.design.columns, effects = work.data.effects.size();
  means.design = Matrix(n, p);
  means.effects = Matrix(n, effects);
  means.output.assign(n, 0.0);
  means.time.assign(n, 0.0);
  means.duration.assign(n, 0.0);
  for (const std::size_t g : means.segments) means.duration[*row[g]] = work.solution.segments[g].duration;
  for (std::size_t i = 0; i < work.data.weights.size(); ++i) {
    if (!row[work.data.segment[i]]) continue;
    const std::size_t r = *row[work.data.segment[i]];
    const double share = work.data.weights[i] / means.duration[r];
    for (std::size_t j = 0; j < p; ++j) means.design(r, j) += share * work.data.design(i, j);
    for (std::size_t k = 0; k < effects; ++k) means.effects(r, k) += share * work.data.effects[k].column[i];
    means.output[r] += share * work.data.observations[i];
    means.time[r] += share * work.rows.time[i];
  }
  add_covariance(work, means);
  return means;
}

/// Which position each segment holds: equal numbers where the same is felt in one power-up.
std::vector<std::size_t> positions_of(const Work& work, const RestingMeans& means) {
  std::vector<std::size_t> position;
  const auto& stretches = work.evidence.test.stretches;
  for (std::size_t a = 0; a < means.segments.size(); ++a) {
    std::size_t first = 0;
    for (; first < a; ++first) {
      const Felt &felt = work.solution.segments[means.segments[a]].felt,
                 &other = work.solution.segments[means.segments[first]].felt;
      if (stretches[means.segments[a]].start == stretches[means.segments[first]].start &&
          norm(felt.specific_force - other.specific_force) < 1e-4 && norm(felt.rate - other.rate) < 1e-9)
        break;
    }
    position.push_back(first == a ? a : position[first]);
  }
  return position;
}

/// Positions against repeats, and repeats against positions.
void look_at_repeats(const Work& work, const std::string& role, const RestingMeans& means, Solution& solution) {
  const auto fit = lack_of_fit(means.design, indicators(positions_of(work, means)), means.output, means.covariance);
  if (!(fit.freedom > 0.0 && fit.error_freedom > 0.0)) return;
  if (fit.error_freedom >= 3.0 && fit.probability < rare)
    solution.findings.push_back({Finding::Severity::warning,
                                 "positions_differ_more_than_repeats",
                                 {{"times", std::sqrt(fit.ratio)}, {"repeats", static_cast<int>(fit.error_freedom)}},
                                 role});
  const double inverse = 1.0 / std::max(fit.ratio, 1e-12);
  if (fit.freedom >= 3.0 && chance_of_ratio(inverse, fit.error_freedom, fit.freedom) < rare)
    solution.findings.push_back(
        {Finding::Severity::warning, "repeats_differ_more_than_positions", {{"times", std::sqrt(inverse)}}, role});
}

/// A drift in time that all positions share.
void look_at_time(const std::string& role, const RestingMeans& means, Solution& solution) {
  const std::size_t n = means.segments.size();
  Matrix time(n, 1);
  for (std::size_t a = 0; a < n; ++a) time(a, 0) = means.time[a];
  const auto [first, last] = std::ranges::minmax(means.time);
  const auto fit = lack_of_fit(means.design, time, means.output, means.covariance);
  std::vector<double> noise;
  for (std::size_t a = 0; a < n; ++a) noise.push_back(std::sqrt(solution.fit.white_variance / means.duration[a]));
  const double change = fit.coefficient * (last - first);
  if (!(fit.error_freedom >= 3.0) || fit.probability > rare || std::abs(change) < 5.0 * median(noise)) return;
  solution.findings.push_back(
      {Finding::Severity::warning,
       "output_drifts_with_time",
       {{"times", std::abs(change) / median(noise)}, {"length", last - first, "s"}, {"ratio", fit.ratio}},
       role});
}

/// Errors of the rig that are far larger than stated.
void look_at_errors(const Work& work, const std::string& role, const RestingMeans& means, Solution& solution) {
  struct Worst {
    LackOfFit fit;
    std::string name;
  };
  std::optional<Worst> worst;
  std::size_t candidates = 0;
  for (std::size_t k = 0; k < work.data.effects.size(); ++k) {
    const KnownEffect& effect = work.data.effects[k];
    if (effect.each_segment) continue;
    const Matrix column = as_column(tumble::column(means.effects, k));
    const auto fit = lack_of_fit(means.design, column, means.output, means.covariance);
    if (!(fit.freedom > 0.0 && fit.error_freedom >= 3.0)) continue;
    ++candidates;
    if (!worst || fit.ratio > worst->fit.ratio)
      worst = {fit, effect.draws.size() == 1 ? effect.draws.front() : effect.source};
  }
  if (!worst || worst->fit.probability * static_cast<double>(candidates) > rare) return;
  // beyond what was stated by itself, however little else scatters
  if (std::abs(worst->fit.coefficient) < 5.0 * std::max(1.0, worst->fit.sd)) return;
  solution.findings.push_back({Finding::Severity::error,
                               "rig_error_beyond_stated",
                               {{"error", worst->name}, {"times", std::abs(worst->fit.coefficient)}},
                               role});
}

/// Change from the first to the second half of a segment.
struct Change {
  double value = 0.0;    ///< [SI]
  double inverse = 0.0;  ///< [1/s] its variance by white noise of unit density
};

std::vector<Change> changes_within(const Work& work) {
  std::vector<Change> changes;
  for (std::size_t g = 0; g < work.solution.segments.size(); ++g) {
    if (!work.solution.segments[g].steady) continue;
    double sum[2] = {0.0, 0.0}, weight[2] = {0.0, 0.0};
    const double middle = work.solution.segments[g].begin + 0.5 * work.evidence.test.stretches[g].duration();
    for (std::size_t i = 0; i < work.rows.segment.size(); ++i) {
      if (work.rows.segment[i] != g) continue;
      const int half = work.rows.time[i] < middle ? 0 : 1;
      sum[half] += work.rows.weights[i] * work.data.observations[i];
      weight[half] += work.rows.weights[i];
    }
    if (weight[0] > 0.0 && weight[1] > 0.0)
      changes.push_back({sum[1] / weight[1] - sum[0] / weight[0], 1.0 / weight[0] + 1.0 / weight[1]});
  }
  return changes;
}

/// Density of the white noise [SI^2 s] without what a ramp that rises by `height` [SI] within each segment adds to the
/// scatter of the averages: height^2/12 to their variance.
double white_without_ramp(const Work& work, double height) {
  const double white = work.solution.fit.white_variance, least = 0.1;
  return std::max(least * white, white - square(height) / 12.0 * median(work.rows.weights));
}

/// The change within the segments that all share, by its scatter; where white noise explains that, few segments
/// suffice.
void look_within(const Work& work, const std::string& role, Solution& solution) {
  const auto changes = changes_within(work);
  if (changes.size() < 3) return;
  const double n = static_cast<double>(changes.size());
  double mean = 0.0, squares = 0.0, inverse = 0.0;
  for (const Change& change : changes) mean += change.value / n, inverse += change.inverse / n;
  for (const Change& change : changes) squares += square(change.value - mean);
  double variance = squares / (n - 1.0), freedom = n - 1.0;
  const double rows = static_cast<double>(work.rows.weights.size()) - n;  // degrees of freedom of the white noise
  const double white = inverse * white_without_ramp(work, 2.0 * mean);
  if (variance < white * chi_square_quantile(0.99, freedom) / freedom) {
    variance = std::max(variance, white);
    freedom += rows;
  } else if (n < 6.0) {
    return;
  }
  if (!(variance > 0.0)) return;
  const double ratio = n * mean * mean / variance;
  if (chance_of_ratio(ratio, 1.0, freedom) > rare) return;
  solution.findings.push_back({Finding::Severity::warning,
                               "output_drifts_within_segments",
                               {{"times", std::sqrt(ratio)}, {"segments", changes.size()}},
                               role});
}

}  // namespace

void warn_of_lack_of_fit(const Problem& problem, Work& work) {
  Solution& solution = work.solution;
  const RestingMeans means = resting_means(work);
  look_within(work, problem.role, solution);
  if (means.segments.size() < work.data.design.columns + 3) return;
  look_at_repeats(work, problem.role, means, solution);
  look_at_time(problem.role, means, solution);
  look_at_errors(work, problem.role, means, solution);
}

}  // namespace tumble::linear
