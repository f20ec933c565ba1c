#include "tumble/methods/rlg_lock_in/departures.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/math/regression/least_squares.hpp"

namespace tumble::rlg_lock_in {
namespace {

constexpr double rare_departure = 1e-3;               ///< probability in a sound sweep, of all that is tried together
constexpr double fewest_free = 3.0;                   ///< degrees of freedom that a comparison needs
constexpr double warm_up_parts[] = {0.05, 0.1, 0.2};  ///< [1] of the sweep: time constants of a warm-up
constexpr double agrees =
    0.01;  ///< probability of scatter between segments beyond that within them: from there on it is another noise
/// [sd] from which on the budget contains what seems to be there; of the senses alone, and of the greatest of all others, of
/// which noise has one above 3 in a sweep in 25.
constexpr double senses_seem_sd = 2.0, seems_sd = 3.0;
constexpr std::size_t fewest_beside_step = 3;  ///< segments on either side: fewer are outliers and not a level

constexpr const char* senses_differ = "scale_factors_of_senses_differ";

/// One thing that the sweep might need.
struct Tried {
  std::string code;
  std::vector<double> column;
  double over = 1.0;       ///< [u] the coefficient times this is what is said
  std::string unit, from;  ///< segment
};

std::vector<Tried> tried_of(const Sweep& sweep, const DeadBand& band, const BandRows& rows) {
  const std::size_t n = rows.rates.size();
  std::vector<Tried> all;
  std::vector<double> scale, lock, drift;
  for (std::size_t k = 0; k < n; ++k) {
    const double sense = rows.rates[k] + band.bias < 0.0 ? -1.0 : 1.0;
    scale.push_back(sense * rows.design(k, 0) / band.scale_factor);
    if (rows.design.columns > 2) lock.push_back(sense * rows.design(k, 2));
    drift.push_back(static_cast<double>(k) / static_cast<double>(std::max<std::size_t>(1, n - 1)));
  }
  all.push_back({senses_differ, std::move(scale), -2.0, "ppm", ""});
  if (!lock.empty()) all.push_back({"lock_in_of_senses_differs", std::move(lock), 2.0, "deg/h", ""});
  all.push_back({"bias_drifts_in_sweep", std::move(drift), -1.0, "deg/h", ""});
  for (const double part : warm_up_parts) {  // from its first value to its last
    std::vector<double> settling;
    for (std::size_t k = 0; k < n; ++k)
      settling.push_back(
          1.0 - std::exp(-static_cast<double>(band.rows[k]) / (part * static_cast<double>(sweep.points.size()))));
    all.push_back({"bias_drifts_in_sweep", std::move(settling), -1.0, "deg/h", ""});
  }
  for (std::size_t at = fewest_beside_step; at + fewest_beside_step <= n; ++at) {
    std::vector<double> step(n, 0.0);
    std::fill(step.begin() + static_cast<std::ptrdiff_t>(at), step.end(), 1.0);
    all.push_back({"bias_steps_in_sweep", std::move(step), -1.0, "deg/h", sweep.points[band.rows[at]].label});
  }
  return all;
}

/// A column beside the fit, compared with the noise between the segments and, where that is no more than the noise within
/// them, with both together.
LackOfFit tested(const BandRows& rows, const NoiseWithin& within, const std::vector<double>& column) {
  const Matrix more = as_column(column), covariance = diagonal(rows.variances);
  LackOfFit free = lack_of_fit(rows.design, more, rows.rates, covariance);
  if (!(within.freedom > 0.0) || !(free.ratio > 0.0)) return free;
  const LackOfFit known = lack_of_fit(rows.design, more, rows.rates, covariance, within.freedom);
  const double between = known.ratio / free.ratio;  // [1] over the variance within
  if (chance_of_ratio(between, free.error_freedom, within.freedom) < agrees) return free;
  const double freedom = free.error_freedom + within.freedom;
  const double pooled = (between * free.error_freedom + within.freedom) / freedom;
  LackOfFit both = known;
  both.ratio = known.ratio / pooled;
  both.sd = known.sd * std::sqrt(pooled);
  both.probability = chance_of_ratio(both.ratio, both.freedom, freedom);
  return both;
}

/// The fit without a column less the fit with it, of (1/K, b, W_L). The scale factor of two senses is the mean of both, from
/// which either is off by half of their difference.
std::vector<double> shift_by(const BandRows& rows, const Tried& tried, double coefficient, const DeadBand& band) {
  std::vector<double> weights;
  for (const double variance : rows.variances) weights.push_back(1.0 / variance);
  std::vector<double> shift = least_squares(rows.design, scaled(coefficient, tried.column), weights, {}).parameters;
  if (tried.code == senses_differ) shift[0] = coefficient / band.scale_factor;
  return shift;
}

}  // namespace

SweepDepartures departures_of(const Sweep& sweep, const DeadBandOptions& options, const DeadBand& band) {
  const NoiseWithin within = noise_within(sweep, options, band);
  const double variance = within.freedom > 0.0 ? within.variance : band.fit.white_variance;
  const BandRows rows = rows_at(sweep, options, band, variance);
  const auto free = static_cast<double>(rows.rates.size()) - static_cast<double>(rows.design.columns) - 1.0;
  if (free < fewest_free) return {};
  const auto all = tried_of(sweep, band, rows);
  double least = rare_departure / static_cast<double>(all.size());
  SweepDepartures out;
  double most = 0.0;
  for (const Tried& one : all) {
    const LackOfFit more = tested(rows, within, one.column);
    const double change = one.over * more.coefficient;
    if (std::sqrt(more.ratio) > std::max(most, one.code == senses_differ ? senses_seem_sd : seems_sd)) {
      most = std::sqrt(more.ratio);
      out.shift = shift_by(rows, one, more.coefficient, band);
    }
    if (more.probability >= least) continue;
    least = more.probability;
    out.findings = {{Finding::Severity::warning,
                     one.code,
                     {{"change", change, one.unit},
                      {"segment", one.from},
                      {"p", std::max(1e-6, static_cast<double>(all.size()) * more.probability)}}}};
  }
  return out;
}

}  // namespace tumble::rlg_lock_in
