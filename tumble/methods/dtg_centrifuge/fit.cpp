#include "tumble/methods/dtg_centrifuge/fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/stability/allan_fit.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A higher order has to lower the AICc by this much: chance does it once in 50 tests, and would make intervals that
/// are too narrow once in 7 were any lower value enough.
constexpr double clearly_better = 4.0;

Complex mean_of(const std::vector<Complex>& part, const std::vector<double>& weight) {
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
  const Complex mean = mean_of(part, weight);
  for (std::size_t k = 0; k < part.size(); ++k) out.squares += weight[k] * std::norm(part[k] - mean);
  out.degrees_of_freedom = 2.0 * (static_cast<double>(part.size()) - 1.0);
  return out;
}

/// Factor for the weights of each level: 1 where the noise is the same in all within chance.
std::vector<double> noise_weights(const std::vector<Observation>& observations, std::size_t levels,
                                  Findings& findings) {
  std::vector<Scatter> of(levels);
  Scatter all;
  for (const Observation& one : observations) {
    const Scatter s = scatter_of(one.part, one.weight);
    of[one.level].squares += s.squares;
    of[one.level].degrees_of_freedom += s.degrees_of_freedom;
    all.squares += s.squares;
    all.degrees_of_freedom += s.degrees_of_freedom;
  }
  std::vector<double> factor(levels, 1.0);
  double statistic = all.degrees_of_freedom * std::log(all.variance()), inverse = -1.0 / all.degrees_of_freedom;
  std::size_t groups = 0;
  double least = INFINITY, most = 0.0;
  for (const Scatter& s : of) {
    if (!(s.squares > 0.0)) continue;
    statistic -= s.degrees_of_freedom * std::log(s.variance());
    inverse += 1.0 / s.degrees_of_freedom;
    least = std::min(least, s.variance());
    most = std::max(most, s.variance());
    ++groups;
  }
  if (groups < 2) return factor;
  const double dof = static_cast<double>(groups) - 1.0;
  statistic /= 1.0 + inverse / (3.0 * dof);
  double size = 0.0, weight = 0.0;
  for (const Observation& one : observations)
    for (std::size_t k = 0; k < one.part.size(); ++k) {
      size += one.weight[k] * std::norm(one.part[k]);
      weight += 1.0;
    }
  const bool rounding = all.variance() < 1e-20 * size / weight;
  if (rounding || !(statistic > chi_square_quantile(0.999, dof))) return factor;
  for (std::size_t k = 0; k < levels; ++k)
    if (of[k].squares > 0.0) factor[k] = all.variance() / of[k].variance();
  findings.push_back(
      {Finding::Severity::info,
       fmt::format("the noise at the table's rate differs between the levels by up to a factor of {:.2g}: "
                   "each has its own",
                   std::sqrt(most / least)),
       ""});
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

  void add_effect(const std::string& source, const std::vector<Complex>& shift) {
    KnownEffect effect{source, std::vector<double>(data.observations.size()), false};
    bool any = false;
    for (std::size_t i = 0; i < effect.column.size(); ++i) {
      const std::size_t segment = data.segment[i];
      const Complex one = shift[segment / components];
      effect.column[i] = segment % components == 0 ? one.real() : one.imag();
      any = any || effect.column[i] != 0.0;
    }
    if (any) data.effects.push_back(std::move(effect));
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

MatrixXd design_of(const std::vector<Level>& levels, Polynomial& polynomial) {
  const std::size_t n = levels.size(), each = polynomial.each();
  MatrixXd design = MatrixXd::Zero(at(n * polynomial.parts), at(each * polynomial.parts));
  for (std::size_t l = 0; l < n; ++l) {
    const auto row = polynomial.row(levels[l]);
    for (std::size_t c = 0; c < polynomial.parts; ++c)
      for (std::size_t k = 0; k < each; ++k) design(at(l * polynomial.parts + c), at(c * each + k)) = row[k];
  }
  return design;
}

}  // namespace

Found fit_levels(const std::vector<Observation>& observations, const std::vector<Effect>& effects, std::size_t levels,
                 Take take, bool unbiased, Findings& findings) {
  const auto factor = noise_weights(observations, levels, findings);
  Rows rows;
  rows.components = take == Take::both_parts ? 2 : 1;
  std::vector<std::pair<std::size_t, std::size_t>> design;
  for (const Observation& one : observations)
    rows.add(take == Take::both_parts ? one.part : along(one, unbiased), one.weight, factor[one.level],
             one.level * rows.components, one.power_up, design);
  rows.close(design, levels * rows.components);
  for (const Effect& effect : effects) {
    auto shift = effect.value;
    if (take == Take::size)
      for (std::size_t n = 0; n < shift.size(); ++n)
        shift[n] *= std::conj(observations[n].value) / std::max(std::abs(observations[n].value), 1e-300);
    rows.add_effect(effect.source, shift);
  }
  rows.add_power_ups();
  Found found;
  found.fit = fit_mixed_model(rows.data);
  found.value = found.fit.parameters;
  return found;
}

Found fit_harmonic(const std::vector<Observation>& observations, const std::vector<Effect>& effects, int harmonic) {
  Rows rows;
  std::vector<std::pair<std::size_t, std::size_t>> design;
  for (const Observation& one : observations) {
    auto weight = one.weight;  // Z_h/a^h: |F|^2 is in it already
    for (double& w : weight) w *= std::pow(std::abs(one.force), 2 * harmonic - 2);
    rows.add(harmonic == 2 ? one.second_part : one.third_part, weight, 1.0, 0, one.power_up, design);
  }
  rows.close(design, 2);
  for (const Effect& effect : effects) rows.add_effect(effect.source, harmonic == 2 ? effect.second : effect.third);
  rows.add_power_ups();
  Found found;
  found.fit = fit_mixed_model(rows.data);
  found.value = found.fit.parameters;
  return found;
}

std::vector<double> Polynomial::row(const Level& level) const {
  std::vector<double> out{1.0};
  if (both_orientations) out.push_back(level.force_along);
  for (int k = 1; k <= powers; ++k) out.push_back(std::pow(level.force, 2 * k));
  return out;
}

Polynomial polynomial_of(const Found& found, const std::vector<Level>& levels, Take take, int powers,
                         double observations) {
  const std::size_t parts = take == Take::both_parts ? 2 : 1;
  const MatrixXd covariance = map(found.fit.covariance);
  const VectorXd y = VectorXd::Map(found.value.data(), at(found.value.size()));
  // scaled to unit diagonal; a floor against rounding where there is no noise
  const VectorXd scale = covariance.diagonal().array().max(1e-26 * y.squaredNorm()).sqrt().inverse();
  MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  correlation.diagonal().array() += 1e-9;
  const Eigen::LLT<MatrixXd> root(correlation);
  const VectorXd white = root.matrixL().solve(scale.cwiseProduct(y));

  std::set<double> up, down;
  for (const Level& level : levels) (level.spin_up > 0.0 ? up : down).insert(level.force);
  const std::size_t different = std::max(up.size(), down.size());
  Polynomial common;
  common.parts = parts;
  common.both_orientations = !up.empty() && !down.empty();
  std::vector<Polynomial> candidates;
  for (int order = 0; order <= 2; ++order) {
    if (order > 0 && static_cast<std::size_t>(order) >= different) break;
    if (order == 2 && different < 4) break;  // a quintic wants a level to spare
    Polynomial one = common;
    one.powers = order;
    const MatrixXd design = design_of(levels, one);
    const MatrixXd whitened = root.matrixL().solve(scale.asDiagonal() * design);
    const VectorXd unit = whitened.colwise().norm().cwiseInverse();
    const Eigen::HouseholderQR<MatrixXd> qr(whitened * unit.asDiagonal());
    const VectorXd b = unit.cwiseProduct(qr.solve(white).eval());
    one.value.assign(b.data(), b.data() + b.size());
    const MatrixXd inverse = root.matrixL().solve(MatrixXd(scale.asDiagonal()));
    one.of_levels = plain(unit.asDiagonal() * qr.solve(inverse));
    const double chi_square = (white - whitened * b).squaredNorm(), k = static_cast<double>(design.cols()) + 1.0;
    const double small = 2.0 * k * (k + 1.0) / std::max(1.0, observations - k - 1.0);
    common.tried.push_back({order, chi_square + 2.0 * k + small, chi_square, false});
    candidates.push_back(std::move(one));
  }
  std::size_t chosen = candidates.size() - 1;
  if (powers >= 0) {
    chosen = std::min(chosen, static_cast<std::size_t>(powers));
  } else if (different > 2) {  // between two levels there is a difference and nothing to judge it by
    const auto lowest = std::ranges::min_element(common.tried, {}, &Order::aicc)->aicc;
    chosen = 0;
    while (common.tried[chosen].aicc > lowest + clearly_better) ++chosen;
  }
  common.tried[chosen].chosen = true;
  candidates[chosen].tried = common.tried;
  return candidates[chosen];
}

}  // namespace tumble::dtg_centrifuge
