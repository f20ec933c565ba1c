#include "tumble/methods/rlg_lock_in/departures.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"

namespace tumble::rlg_lock_in {
namespace {

constexpr double rare_departure = 1e-3;        ///< probability in a sound sweep, of all that is tried together
constexpr double fewest_free = 3.0;            ///< degrees of freedom that a comparison needs
constexpr std::size_t fewest_beside_step = 3;  ///< segments on either side: fewer are outliers and not a level

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
  all.push_back({"scale_factors_of_senses_differ", std::move(scale), -2.0, "ppm", ""});
  if (!lock.empty()) all.push_back({"lock_in_of_senses_differs", std::move(lock), 2.0, "deg/h", ""});
  all.push_back({"bias_drifts_in_sweep", std::move(drift), -1.0, "deg/h", ""});
  for (std::size_t at = fewest_beside_step; at + fewest_beside_step <= n; ++at) {
    std::vector<double> step(n, 0.0);
    std::fill(step.begin() + static_cast<std::ptrdiff_t>(at), step.end(), 1.0);
    all.push_back({"bias_steps_in_sweep", std::move(step), -1.0, "deg/h", sweep.points[band.rows[at]].label});
  }
  return all;
}

}  // namespace

Findings departures_of(const Sweep& sweep, const DeadBandOptions& options, const DeadBand& band) {
  const BandRows rows = rows_at(sweep, options, band);
  const auto free = static_cast<double>(rows.rates.size()) - static_cast<double>(rows.design.columns) - 1.0;
  if (free < fewest_free) return {};
  const auto all = tried_of(sweep, band, rows);
  double least = rare_departure / static_cast<double>(all.size());
  Findings findings;
  for (const Tried& one : all) {
    const LackOfFit more = lack_of_fit(rows.design, as_column(one.column), rows.rates, diagonal(rows.variances));
    if (more.probability >= least) continue;
    least = more.probability;
    findings = {{Finding::Severity::warning,
                 one.code,
                 {{"change", one.over * more.coefficient, one.unit},
                  {"segment", one.from},
                  {"p", std::max(1e-6, static_cast<double>(all.size()) * more.probability)}}}};
  }
  return findings;
}

}  // namespace tumble::rlg_lock_in
