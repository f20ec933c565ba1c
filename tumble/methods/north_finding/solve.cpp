#include "tumble/methods/north_finding/solve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/units/error.hpp"

namespace tumble::north_finding {
namespace {

constexpr double least_row = 1e-18, least_of_known = 1e-10;  ///< [1] of the slopes, rounding; [1] of all variances
constexpr double most_condition = 1e10;       ///< of the azimuth with its columns, beyond which nothing is determined
constexpr double azimuth_settled = 1e-13;     ///< [rad] rounding
constexpr double longest_azimuth_step = 0.5;  ///< [rad] of a step, over which the sine is nearly a line

/// Effects of one source, each by one standard deviation of its own.
struct Source {
  std::string name;
  Matrix columns;        ///< [rows x effects]
  std::string key = {};  ///< see Contribution
};

/// All rows of all signals at one state.
struct System {
  std::vector<double> residual;
  Matrix slopes;                ///< by all quantities
  std::vector<double> white;    ///< variance of each row by white noise
  std::vector<double> scatter;  ///< and by what rounding adds in a turn: what rows are weighted by
  std::vector<Source> sources;
};

/// First row of each signal among all, and the number of all.
std::vector<std::size_t> firsts_of(const Bench& bench) {
  std::vector<std::size_t> firsts{0};
  for (const auto& signal : bench.signals) firsts.push_back(firsts.back() + signal.rows.size());
  return firsts;
}

/// A matrix whose square is this covariance [n x n], its columns those of a source.
Matrix root_of(const Matrix& covariance) {
  const auto eigen = eigen_symmetric(covariance);
  std::vector<double> sd;
  for (const double variance : eigen.values) sd.push_back(std::sqrt(std::max(variance, 0.0)));
  return scaled_columns(eigen.vectors, sd);
}

void add_noise(const Bench& bench, const std::vector<Noise>& noise, const std::vector<std::size_t>& firsts,
               System& system) {
  for (std::size_t c = 0; c < bench.signals.size(); ++c) {
    const auto& signal = bench.signals[c];
    const std::string of = bench.signals.size() > 1 ? std::string(" of ") + signal.problem.role : "";
    for (const auto& slow : noise[c].slow) {
      const Matrix root = root_of(slow.variance * slow.kernel);
      Source source{slow.source + of, Matrix(firsts.back(), root.columns)};
      for (std::size_t r = 0; r < signal.rows.size(); ++r)
        for (std::size_t k = 0; k < root.columns; ++k)
          source.columns(firsts[c] + r, k) = root(signal.rows[r].position, k);
      if (std::ranges::any_of(source.columns.values, [](double v) { return v != 0.0; }))
        system.sources.push_back(std::move(source));
    }
    if (!(signal.problem.pulse > 0.0)) continue;
    Source source{"counting" + of, Matrix(firsts.back(), signal.rows.size())};
    for (std::size_t r = 0; r < signal.rows.size(); ++r) source.columns(firsts[c] + r, r) = signal.rows[r].rounding_sd;
    system.sources.push_back(std::move(source));
  }
}

void add_rig(const Bench& bench, const State& state, const std::vector<Disturbance>& disturbances, System& system) {
  for (const auto& disturbance : disturbances) {
    std::vector<double> shift;
    for (std::size_t c = 0; c < bench.signals.size(); ++c) {
      const auto effect = effect_of(bench.signals[c], disturbance.moves[c], state);
      shift.insert(shift.end(), effect.begin(), effect.end());
    }
    system.sources.push_back({disturbance.source, as_column(shift), disturbance.key});
  }
}

void add_priors(const Instrument& instrument, System& system) {
  for (const auto& prior : instrument.priors) {
    const std::vector<std::size_t> of(prior.of.begin(), prior.of.end());
    system.sources.push_back({prior.source, chosen_columns(system.slopes, of) * root_of(prior.covariance)});
  }
}

System system_at(const Bench& bench, const State& state, const std::vector<Noise>& noise,
                 const std::vector<Disturbance>& disturbances, const Instrument& instrument, bool predicted) {
  const auto firsts = firsts_of(bench);
  const std::size_t n = firsts.back();
  const std::vector<double> zeros(n, 0.0);
  System system{zeros, Matrix(n, quantities), zeros, zeros, {}};
  for (std::size_t c = 0; c < bench.signals.size(); ++c)
    for (std::size_t r = 0; r < bench.signals[c].rows.size(); ++r) {
      const Row& row = bench.signals[c].rows[r];
      const std::size_t i = firsts[c] + r;
      if (!predicted) system.residual[i] = row.output - output_of(state, row);
      const auto slopes = slopes_of(state, row);
      for (std::size_t k = 0; k < quantities; ++k) system.slopes(i, k) = slopes[k];
      system.white[i] = noise[c].white / row.seconds;
      system.scatter[i] = noise[c].scatter / row.seconds;
    }
  add_noise(bench, noise, firsts, system);
  add_rig(bench, state, disturbances, system);
  add_priors(instrument, system);
  return system;
}

/// Standard deviations that rows are divided by: of the white noise, but never less than a trace of all that moves the
/// row or of its rounding.
std::vector<double> deviations_of(const System& system) {
  std::vector<double> out;
  for (std::size_t i = 0; i < system.scatter.size(); ++i) {
    double total = system.scatter[i], size = 0.0;
    for (const auto& source : system.sources)
      for (std::size_t j = 0; j < source.columns.columns; ++j) total += std::pow(source.columns(i, j), 2);
    for (std::size_t k = 0; k < quantities; ++k) size = std::max(size, least_row * std::abs(system.slopes(i, k)));
    out.push_back(std::sqrt(std::max({system.scatter[i], least_of_known * total, size * size, 1e-300})));
  }
  return out;
}

/// The linear estimator: free quantities from rows.
struct Estimator {
  Matrix gain;  ///< [free x rows]
  double chi_square = 0.0, condition = 0.0;
};

/// Rows and effects of the whitened system: the effects first, so that what the free quantities show beyond them comes
/// last and is solved for first.
///
///   [ W E   W X ]   W = diag(weight), E effects of the sources, X slopes by the free quantities
///   [  1     0  ]
Matrix whitened(const System& system, const std::vector<Quantity>& free, const std::vector<double>& weight) {
  Matrix effects;
  for (const auto& source : system.sources) effects = beside(effects, source.columns);
  const std::size_t n = weight.size(), m = effects.columns, p = free.size();
  Matrix out(n + m, m + p);
  if (m > 0) set_block(out, 0, 0, scaled_rows(weight, effects));
  set_block(out, 0, m,
            scaled_rows(weight, chosen_columns(system.slopes, std::vector<std::size_t>(free.begin(), free.end()))));
  for (std::size_t j = 0; j < m; ++j) out(n + j, j) = 1.0;
  return out;
}

Estimator estimator_of(const System& system, const std::vector<Quantity>& free) {
  const auto weight = inverses(deviations_of(system));
  const Matrix a = whitened(system, free, weight);
  const std::size_t n = weight.size(), p = free.size(), effects = a.columns - p;
  const auto size = inverses(column_norms(a), 1e-300);
  const auto qr = householder_qr(scaled_columns(a, size));
  const Matrix r = block(upper_of(qr), effects, p, effects, p);
  Matrix last(a.rows, p);
  set_block(last, effects, 0, identity(p));
  const Matrix q = q_product(qr, last);  // the columns of Q that belong to the free quantities
  Estimator out;
  out.condition = condition(r);
  out.gain =
      scaled_rows(std::span(size).last(p), scaled_columns(solve_upper(r, transposed(block(q, 0, n, 0, p))), weight));
  auto y = scaled(weight, system.residual);
  y.resize(a.rows, 0.0);
  const auto turned = q_transposed_product(qr, y);
  const auto rest = std::span(turned).subspan(a.columns);
  out.chi_square = dot(rest, rest);
  return out;
}

void check_gain(const Estimator& estimator) {
  if (!std::ranges::all_of(estimator.gain.values, [](double v) { return std::isfinite(v); }) ||
      !(estimator.condition < most_condition))
    throw Error(Error::Kind::bad_data,
                "the index angles do not show the azimuth: near this heading the rate does not change with it (two "
                "positions near north and south), or angles are missing; add positions 90 deg apart");
}

/// Welch and Satterthwaite: nu = 2 v^2/Var(v), the variance of v from that of the estimated components.
double freedom_of(const Bench& bench, const std::vector<Noise>& noise, const std::vector<std::size_t>& firsts,
                  const std::vector<double>& gain, double v) {
  double of_v = 0.0;
  for (std::size_t c = 0; c < bench.signals.size(); ++c) {
    if (noise[c].component_covariance.empty()) continue;
    const auto& signal = bench.signals[c];
    std::vector<double> gradient(noise[c].component_covariance.rows, 0.0), by_position(signal.positions.size(), 0.0);
    for (std::size_t r = 0; r < signal.rows.size(); ++r) {
      const double g = gain[firsts[c] + r];
      gradient[0] += g * g / signal.rows[r].seconds;
      by_position[signal.rows[r].position] += g;
    }
    for (std::size_t k = 1; k < gradient.size(); ++k)
      gradient[k] = quadratic_form(by_position, noise[c].slow[k - 1].kernel);
    of_v += quadratic_form(gradient, noise[c].component_covariance);
  }
  return of_v > 0.0 ? std::max(1.0, 2.0 * v * v / of_v) : std::numeric_limits<double>::infinity();
}

/// Covariance by rounding to whole pulses where a table turns: neighbours share a reading.
Matrix counted_turns(const Bench& bench, const std::vector<std::size_t>& firsts, const Matrix& gain) {
  Matrix covariance(gain.rows, gain.rows);
  std::vector<double> end(gain.rows, 0.0);  // of the reading after the row before
  for (std::size_t c = 0; c < bench.signals.size(); ++c)
    for (std::size_t r = 0; r < bench.signals[c].rows.size(); ++r) {
      const Row& row = bench.signals[c].rows[r];
      const auto now = scaled(row.reading_sd, column(gain, firsts[c] + r));
      if (!row.follows) {
        add_square(covariance, 1.0, end);
        std::ranges::fill(end, 0.0);
      }
      add_square(covariance, 1.0, difference(end, now));
      end = now;
    }
  add_square(covariance, 1.0, end);
  return covariance;
}

void fill(const Bench& bench, const std::vector<Noise>& noise, const System& system, const Estimator& estimator,
          Solution& out) {
  const Matrix& g = estimator.gain;
  const auto firsts = firsts_of(bench);
  for (std::size_t c = 0; c < bench.signals.size(); ++c) {
    const std::size_t rows = bench.signals[c].rows.size();
    const auto white = std::span(system.white).subspan(firsts[c], rows);
    out.lines.push_back(
        from_covariance(bench.signals.size() > 1 ? "output noise of " + bench.signals[c].problem.role : "output noise",
                        sandwich(block(g, 0, g.rows, firsts[c], rows), white)));
  }
  for (const auto& source : system.sources)
    out.lines.push_back(from_shifts(source.name, g * source.columns, source.key));
  if (const Matrix turns = counted_turns(bench, firsts, g); trace(turns) > 0.0)
    out.lines.push_back(from_covariance("counting of turns", turns));
  out.covariance = covariance_of(out.lines, g.rows);
  for (std::size_t k = 0; k < g.rows; ++k)
    out.degrees_of_freedom.push_back(freedom_of(bench, noise, firsts, row(g, k), out.covariance(k, k)));
  out.gain = g;
  out.fit = {g.columns, static_cast<double>(g.columns - g.rows), estimator.chi_square, estimator.condition};
}

}  // namespace

Solution solve(const Bench& bench, const Instrument& instrument, const Setup& setup, const std::vector<Noise>& noise,
               const std::vector<Disturbance>& disturbances, bool predicted) {
  Solution out;
  out.state = setup.start;
  out.free = setup.free;
  constexpr int least = 2, most = 30;  // the azimuth may be right from the start while the rest is not
  for (int step = 0;; ++step) {
    const System system = system_at(bench, out.state, noise, disturbances, instrument, predicted);
    const Estimator estimator = estimator_of(system, setup.free);
    check_gain(estimator);
    const auto change = estimator.gain * system.residual;
    const double turn = std::abs(change[0]);
    if (predicted || (step >= least && turn < azimuth_settled) || step == most) {
      fill(bench, noise, system, estimator, out);
      return out;
    }
    const double share = std::min(1.0, longest_azimuth_step / std::max(turn, 1e-300));
    for (std::size_t k = 0; k < setup.free.size(); ++k) out.state[setup.free[k]] += share * change[k];
  }
}

}  // namespace tumble::north_finding
