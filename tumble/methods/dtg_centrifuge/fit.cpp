#include "tumble/methods/dtg_centrifuge/fit.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/stability/allan_fit.hpp"
#include "tumble/units/error.hpp"

namespace tumble::dtg_centrifuge {
namespace {

constexpr double no_noise = 1e-20;  ///< [1] of the mean square of the parts, below which their variance is rounding
constexpr double variance_added = 1e-9;  ///< [1] of each variance: levels without noise do not make the matrix singular
/// [1] of the squares: below it a variance is the rounding of the levels.
constexpr double variance_of_rounding = 1e-26;
constexpr double free_of_noise = 1e6;  ///< [1] of the greatest weight: that of a row which is known and not measured
constexpr double other_force = 1.02;   ///< ratio of two specific forces, from which on they are two levels

Complex weighted_mean(const std::vector<Complex>& part, const std::vector<double>& weight) {
  Complex sum = 0.0;
  double total = 0.0;
  for (std::size_t k = 0; k < part.size(); ++k) {
    sum += weight[k] * part[k];
    total += weight[k];
  }
  return sum / total;
}

/// Scatter of the parts about the mean of their observation, in units of the noise density [u^2 s], and its degrees of
/// freedom; `both`: of both components.
struct Scatter {
  double squares = 0.0, degrees_of_freedom = 0.0;
  double variance() const { return squares / degrees_of_freedom; }
};

Scatter scatter_of(const std::vector<Complex>& part, const std::vector<double>& weight) {
  Scatter out;
  const Complex mean = weighted_mean(part, weight);
  for (std::size_t k = 0; k < part.size(); ++k) out.squares += weight[k] * std::norm(part[k] - mean);
  out.degrees_of_freedom = 2.0 * (static_cast<double>(part.size()) - 1.0);
  return out;
}

/// Scatter at each level, and over all levels.
struct LevelScatter {
  std::vector<Scatter> of;
  Scatter all;
};

LevelScatter scatter_of(const std::vector<Observation>& observations, std::size_t levels) {
  LevelScatter out{std::vector<Scatter>(levels), {}};
  for (const Observation& one : observations) {
    const Scatter s = scatter_of(one.part, one.weight);
    for (Scatter* sum : {&out.of[one.level], &out.all}) {
      sum->squares += s.squares;
      sum->degrees_of_freedom += s.degrees_of_freedom;
    }
  }
  return out;
}

/// Whether the variances are below the rounding of the parts themselves.
bool only_rounding(const std::vector<Observation>& observations, double variance) {
  double size = 0.0, count = 0.0;
  for (const Observation& one : observations)
    for (std::size_t k = 0; k < one.part.size(); ++k) {
      size += one.weight[k] * std::norm(one.part[k]);
      count += 1.0;
    }
  return variance < no_noise * size / count;
}

/// Bartlett's test of equal variances, at 0.1 %.
bool noise_differs(const LevelScatter& scatter) {
  const Scatter& all = scatter.all;
  double statistic = all.degrees_of_freedom * std::log(all.variance()), inverse = -1.0 / all.degrees_of_freedom;
  double dof = -1.0;
  for (const Scatter& s : scatter.of) {
    if (!(s.squares > 0.0)) continue;
    statistic -= s.degrees_of_freedom * std::log(s.variance());
    inverse += 1.0 / s.degrees_of_freedom;
    dof += 1.0;
  }
  return dof >= 1.0 && statistic / (1.0 + inverse / (3.0 * dof)) > chi_square_quantile(exceeded_in_1000, dof);
}

/// Factor for the weights of each level: 1 where the noise does not differ significantly between the levels.
std::vector<double> noise_weights(const std::vector<Observation>& observations, std::size_t levels,
                                  Findings& findings) {
  const LevelScatter scatter = scatter_of(observations, levels);
  std::vector<double> factor(levels, 1.0);
  if (!noise_differs(scatter) || only_rounding(observations, scatter.all.variance())) return factor;
  double least = INFINITY, most = 0.0;
  for (std::size_t k = 0; k < levels; ++k) {
    if (!(scatter.of[k].squares > 0.0)) continue;
    const double variance = scatter.of[k].variance();
    factor[k] = scatter.all.variance() / variance;
    least = std::min(least, variance);
    most = std::max(most, variance);
  }
  findings.push_back({Finding::Severity::info, "noise_differs_between_levels", {{"factor", std::sqrt(most / least)}}});
  return factor;
}

/// Components of the observations as rows of a mixed model: segment = observation and component.
struct Rows {
  MixedData data;
  std::vector<std::size_t> power_up;  ///< of each segment
  std::size_t components = 2;

  void add(const std::vector<Complex>& part, const std::vector<double>& weight, double factor, std::size_t column,
           std::size_t of_power_up, std::vector<std::pair<std::size_t, std::size_t>>& design) {
    for (std::size_t c = 0; c < components; ++c) {
      for (std::size_t k = 0; k < part.size(); ++k) {
        data.observations.push_back(c == 0 ? part[k].real() : part[k].imag());
        data.weights.push_back(weight[k] * factor);
        data.segment.push_back(power_up.size());
        design.emplace_back(data.observations.size() - 1, column + c);
      }
      power_up.push_back(of_power_up);
    }
  }

  void close(const std::vector<std::pair<std::size_t, std::size_t>>& design, std::size_t columns) {
    data.design = Matrix(data.observations.size(), columns);
    for (const auto& [row, column] : design) data.design(row, column) = 1.0;
  }

  void add_effect(const Effect& from, const std::vector<Complex>& shift) {
    KnownEffect effect{from.source, std::vector<double>(data.observations.size()), false, {}, from.key};
    bool any = false;
    for (std::size_t i = 0; i < effect.column.size(); ++i) {
      const std::size_t segment = data.segment[i];
      const Complex one = shift[segment / components];
      effect.column[i] = segment % components == 0 ? one.real() : one.imag();
      any = any || effect.column[i] != 0.0;
    }
    if (any) data.effects.push_back(std::move(effect));
  }

  /// A segment of its own: the lag by what else is known of it, in numbers as large as what a unit of it changes.
  void add_lag(const LagColumn& lag, std::size_t column) {
    if (lag.shift.empty()) return;
    const std::size_t rows = data.observations.size();
    double size = 0.0;
    for (const Complex one : lag.shift) size = std::max(size, std::abs(one));
    if (size == 0.0) size = 1.0;
    for (std::size_t i = 0; i < rows; ++i) {
      const Complex one = lag.shift[data.segment[i] / components];
      data.design(i, column) = data.segment[i] % components == 0 ? one.real() : one.imag();
    }
    Matrix design(rows + 1, data.design.columns);
    for (std::size_t c = 0; c < design.columns; ++c)
      for (std::size_t i = 0; i < rows; ++i) design(i, c) = data.design(i, c);
    design(rows, column) = size;
    data.design = std::move(design);
    data.observations.push_back(size * lag.expected);
    data.weights.push_back(free_of_noise * *std::ranges::max_element(data.weights));
    data.segment.push_back(data.segment.back() + 1);
    for (KnownEffect& effect : data.effects) effect.column.push_back(0.0);
    for (SlowNoise& slow : data.slow) {
      Matrix kernel(power_up.size() + 1, power_up.size() + 1);
      for (std::size_t a = 0; a < power_up.size(); ++a)
        for (std::size_t b = 0; b < power_up.size(); ++b) kernel(a, b) = slow.kernel(a, b);
      slow.kernel = std::move(kernel);
    }
    KnownEffect beforehand{lag_source, std::vector<double>(rows + 1), false};
    beforehand.column.back() = size * lag.sd;
    data.effects.push_back(std::move(beforehand));
  }

  void add_power_ups() {
    const std::size_t n = power_up.size();
    if (std::set<std::size_t>(power_up.begin(), power_up.end()).size() < 2) return;
    SlowNoise noise{"repeatability from power-up to power-up", Matrix(n, n)};
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b)
        noise.kernel(a, b) = power_up[a] == power_up[b] && a % components == b % components ? 1.0 : 0.0;
    data.slow.push_back(std::move(noise));
  }
};

/// Parts as they lie along their mean: what is across is phase, which nobody recorded.
std::vector<Complex> along(const Observation& one, bool unbiased) {
  const Complex direction = one.value / std::max(std::abs(one.value), 1e-300);
  double total = 0.0;
  for (const double w : one.weight) total += w;
  const Scatter s = scatter_of(one.part, one.weight);
  const double size = std::abs(one.value), across = s.variance() / total;
  // |y| is too large by the variance across over 2 |y| on average: docs/equations (1.14) for |y| in place of its square
  const double bias = unbiased && size * size > across ? size - std::sqrt(size * size - across) : 0.0;
  std::vector<Complex> out;
  for (const Complex part : one.part) out.emplace_back((part * std::conj(direction)).real() - bias, 0.0);
  return out;
}

Matrix design_of(const std::vector<Level>& levels, const Polynomial& polynomial, bool lag) {
  const std::size_t each = polynomial.each(), rows = levels.size() * polynomial.parts;
  const std::size_t of_parts = each * polynomial.parts;
  Matrix design(rows + (lag ? 1 : 0), of_parts + (lag ? 1 : 0));
  if (lag) design(rows, of_parts) = 1.0;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const auto row = polynomial.row(levels[l]);
    for (std::size_t c = 0; c < polynomial.parts; ++c)
      for (std::size_t k = 0; k < each; ++k) design(l * polynomial.parts + c, c * each + k) = row[k];
  }
  return design;
}

/// The levels with unit variance: L^-1 diag(scale) of their covariance.
struct White {
  std::vector<double> scale, y;
  Matrix lower;  ///< L, Cholesky factor of the scaled covariance

  explicit White(const Quantities& levels) {
    const Matrix& covariance = levels.fit.covariance;
    // scaled to unit diagonal; a floor against rounding where there is no noise
    const double floor = variance_of_rounding * dot(levels.value, levels.value);
    for (const double variance : diagonal_of(covariance)) scale.push_back(1.0 / std::sqrt(std::max(variance, floor)));
    Matrix correlation = scaled_rows(scale, scaled_columns(covariance, scale));
    for (std::size_t k = 0; k < scale.size(); ++k) correlation(k, k) += variance_added;
    const Cholesky root = cholesky(correlation);
    if (!root.positive) throw Error(Error::Kind::bad_data, "the noise of the levels could not be determined");
    lower = root.lower;
    y = solve_lower(lower, scaled(scale, levels.value));
  }
  Matrix of(const Matrix& rows) const { return solve_lower(lower, scaled_rows(scale, rows)); }
};

/// Number of specific forces with this orientation that differ by more than 2 %: one may be tested at several net
/// rates.
std::size_t forces_of(const std::vector<Level>& levels, double spin_up) {
  std::size_t count = 0;
  double last = 0.0;
  for (const Level& level : levels) {  // by specific force
    if (level.spin_up * spin_up < 0.0 || !(level.force > other_force * last)) continue;
    last = level.force;
    ++count;
  }
  return count;
}

/// Fit of one order; adds its score to `tried`.
Polynomial of_order(int order, const Polynomial& common, const White& levels, const std::vector<Level>& of,
                    double observations, std::vector<Order>& tried) {
  Polynomial out = common;
  out.powers = order;
  const Matrix design = levels.of(design_of(of, out, levels.y.size() > of.size() * out.parts));
  const auto unit = inverses(column_norms(design));
  const HouseholderQr qr = householder_qr(scaled_columns(design, unit));
  out.value = scaled(unit, solve(qr, levels.y));
  out.of_levels = scaled_rows(unit, solve(qr, levels.of(identity(levels.scale.size()))));
  const auto residual = difference(levels.y, design * out.value);
  const double chi_square = dot(residual, residual), k = static_cast<double>(design.columns) + 1.0;
  const double small = 2.0 * k * (k + 1.0) / std::max(1.0, observations - k - 1.0);
  tried.push_back({order, chi_square + 2.0 * k + small, chi_square, false});
  return out;
}

}  // namespace

Quantities fit_levels(const std::vector<Observation>& observations, const std::vector<Effect>& effects,
                      std::size_t levels, Take take, bool unbiased, const LagColumn& lag, Findings& findings) {
  const auto factor = noise_weights(observations, levels, findings);
  Rows rows;
  rows.components = take == Take::both_parts ? 2 : 1;
  std::vector<std::pair<std::size_t, std::size_t>> design;
  for (const Observation& one : observations)
    rows.add(take == Take::both_parts ? one.part : along(one, unbiased), one.weight, factor[one.level],
             one.level * rows.components, one.power_up, design);
  rows.close(design, levels * rows.components + (lag.shift.empty() ? 0 : 1));
  for (const Effect& effect : effects) {
    auto shift = effect.value;
    if (take == Take::size)
      for (std::size_t n = 0; n < shift.size(); ++n)
        shift[n] *= std::conj(observations[n].value) / std::max(std::abs(observations[n].value), 1e-300);
    rows.add_effect(effect, shift);
  }
  rows.add_power_ups();
  rows.add_lag(lag, levels * rows.components);
  Quantities quantities;
  quantities.fit = fit_mixed_model(rows.data);
  quantities.value = quantities.fit.parameters;
  return quantities;
}

Quantities fit_harmonic(const std::vector<Observation>& observations, const std::vector<Effect>& effects, int harmonic,
                        const LagColumn& lag) {
  Rows rows;
  std::vector<std::pair<std::size_t, std::size_t>> design;
  for (const Observation& one : observations) {
    auto weight = one.weight;  // Z_h/a^h: |F|^2 is in it already
    for (double& w : weight) w *= std::pow(std::abs(one.force), 2 * harmonic - 2);
    rows.add(harmonic == 2 ? one.second_part : one.third_part, weight, 1.0, 0, one.power_up, design);
  }
  rows.close(design, lag.shift.empty() ? 2 : 3);
  for (const Effect& effect : effects) rows.add_effect(effect, harmonic == 2 ? effect.second : effect.third);
  rows.add_power_ups();
  rows.add_lag(lag, 2);
  Quantities quantities;
  quantities.fit = fit_mixed_model(rows.data);
  quantities.value = quantities.fit.parameters;
  return quantities;
}

std::vector<double> Polynomial::row(const Level& level) const {
  std::vector<double> out{1.0};
  if (both_orientations) out.push_back(level.force_along);
  for (int k = 1; k <= powers; ++k) out.push_back(std::pow(level.force, 2 * k));
  return out;
}

Polynomial polynomial_of(const Quantities& quantities, const std::vector<Level>& levels, Take take, int powers,
                         double observations) {
  const std::size_t up = forces_of(levels, 1.0), down = forces_of(levels, -1.0), different = std::max(up, down);
  Polynomial common;
  common.parts = take == Take::both_parts ? 2 : 1;
  common.both_orientations = up > 0 && down > 0;
  const White white(quantities);
  std::vector<Order> tried;
  std::vector<Polynomial> candidates;
  for (int order = 0; order <= 2; ++order) {
    if (order > 0 && static_cast<std::size_t>(order) >= different) break;
    if (order == 2 && different < 4) break;  // a quintic wants a level to spare
    candidates.push_back(of_order(order, common, white, levels, observations, tried));
  }
  std::size_t chosen = candidates.size() - 1;
  if (powers >= 0) chosen = std::min(chosen, static_cast<std::size_t>(powers));
  tried[chosen].chosen = true;
  candidates[chosen].tried = tried;
  candidates[chosen].automatic = powers < 0;
  return candidates[chosen];
}

}  // namespace tumble::dtg_centrifuge
