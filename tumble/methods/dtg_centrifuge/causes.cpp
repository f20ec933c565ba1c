#include "tumble/methods/dtg_centrifuge/causes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"

namespace tumble::dtg_centrifuge {
namespace {

/// [1] of each variance: levels without noise do not make the matrix singular.
constexpr double variance_beside = 1e-9;

/// The polynomial, and the lag where it is a quantity, by the quantities of the levels.
Matrix design_by_levels(const Outcome& outcome, const std::vector<Level>& levels) {
  const Polynomial& p = outcome.polynomial;
  const std::size_t each = p.each();
  Matrix design(outcome.levels.value.size(), p.value.size());
  if (p.has_lag()) design(design.rows - 1, design.columns - 1) = 1.0;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const auto row = p.row(levels[l]);
    for (std::size_t c = 0; c < p.parts; ++c)
      for (std::size_t k = 0; k < each; ++k) design(l * p.parts + c, c * each + k) = row[k];
  }
  return design;
}

/// What a change of each observation's y = p - i sigma q makes of the levels: [2L x 2], for the change times 1 and times i.
Matrix by_levels(const Outcome& outcome, const std::vector<Measured>& measured,
                 const std::function<Complex(const Observation&, double sigma, Complex number)>& change) {
  Matrix out(outcome.levels.value.size(), 2);
  std::vector<double> count(outcome.levels.value.size() / 2 + 1, 0.0);
  for (const Observation& o : outcome.observations) count[o.level] += 1.0;
  for (const Observation& o : outcome.observations) {
    const double sigma = measured[o.measured].stretch->spin_up;
    for (std::size_t k = 0; k < 2; ++k) {
      const Complex y = change(o, sigma, k == 0 ? Complex(1.0) : Complex(0.0, 1.0));
      out(2 * o.level, k) += y.real() / count[o.level];
      out(2 * o.level + 1, k) -= sigma * y.imag() / count[o.level];
    }
  }
  return out;
}

/// Least squares with the covariance of the levels, with and without two columns more.
Cause fitted_cause(const Outcome& outcome, const std::vector<Level>& levels, const Matrix& more) {
  const Quantities& y = outcome.levels;
  const Matrix design = design_by_levels(outcome, levels);
  Cause cause;
  if (design.rows < design.columns + more.columns) return cause;
  const auto scale = inverses([&] {
    std::vector<double> sd;
    for (const double variance : diagonal_of(y.fit.covariance)) sd.push_back(std::sqrt(variance));
    return sd;
  }());
  Matrix correlation = scaled_rows(scale, scaled_columns(y.fit.covariance, scale));
  for (std::size_t k = 0; k < scale.size(); ++k) correlation(k, k) += variance_beside;
  const Cholesky root = cholesky(correlation);
  if (!root.positive) return cause;
  Matrix both(design.rows, design.columns + 2);
  for (std::size_t i = 0; i < design.rows; ++i)
    for (std::size_t k = 0; k < both.columns; ++k)
      both(i, k) = k < design.columns ? design(i, k) : more(i, k - design.columns);
  const auto left = [&](const Matrix& columns_of, std::vector<double>& b) {
    const Matrix white = solve_lower(root.lower, scaled_rows(scale, columns_of));
    const auto seen = solve_lower(root.lower, scaled(scale, y.value));
    const auto unit = inverses(column_norms(white));
    b = scaled(unit, solve(householder_qr(scaled_columns(white, unit)), seen));
    const auto residual = difference(seen, white * b);
    return dot(residual, residual);
  };
  std::vector<double> plain, with;
  cause.fall = left(design, plain) - left(both, with);
  cause.value = Complex(with[design.columns], with[design.columns + 1]);
  cause.probability = chance_of_ratio(0.5 * cause.fall, 2.0, y.fit.degrees_of_freedom);
  return cause;
}

}  // namespace

Cause other_relation(const Outcome& outcome, const std::vector<Measured>& measured, const std::vector<Level>& levels) {
  if (outcome.take != Take::both_parts) return {};
  // c = exp(log gain - i sigma azimuth), and conj(c) times the line of the reference is what was subtracted
  const auto change = [](const Observation& o, double sigma, Complex number) {
    return -Complex(number.real(), sigma * number.imag()) * o.true_rate / o.force;
  };
  return fitted_cause(outcome, levels, by_levels(outcome, measured, change));
}

Cause line_beside_force(const Outcome& outcome, const std::vector<Measured>& measured,
                        const std::vector<Level>& levels) {
  if (outcome.take != Take::both_parts) return {};
  const auto change = [](const Observation& o, double sigma, Complex number) {
    return (sigma < 0.0 ? std::conj(number) : number) / o.force;
  };
  return fitted_cause(outcome, levels, by_levels(outcome, measured, change));
}

void name_cause(const Outcome& outcome, const std::vector<Measured>& measured, const std::vector<Level>& levels,
                Findings& findings) {
  const Cause relation = other_relation(outcome, measured, levels);
  const Cause beside = line_beside_force(outcome, measured, levels);
  if (std::min(relation.probability, beside.probability) > rare_cause) return;
  const char* channel = outcome.output == gyro ? "gyro" : "gyro_y";
  if (relation.fall > beside.fall)
    findings.push_back({Finding::Severity::error,
                        "reference_relation_differs",
                        {{"gain", -relation.value.real(), "%"}, {"azimuth", relation.value.imag(), "deg"}},
                        channel});
  else
    findings.push_back(
        {Finding::Severity::error, "line_beside_force", {{"size", std::abs(beside.value), "deg/h"}}, channel});
}

}  // namespace tumble::dtg_centrifuge
