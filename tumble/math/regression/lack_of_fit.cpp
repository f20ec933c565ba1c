#include "tumble/math/regression/lack_of_fit.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <utility>

#include "tumble/math/linear_algebra.hpp"

namespace tumble {
namespace {

/// [1] of the largest variance; of each: rows without noise.
constexpr double least_of_largest = 1e-18, added_to_unit = 1e-9;

constexpr double same_column = 1e-7;  ///< share of a column that the others do not explain: it is rounding

/// Rows of unit variance. Rows without any noise count as one part in 1e9 of the others.
struct Whitener {
  std::vector<double> unit;
  Matrix root;

  explicit Whitener(const Matrix& covariance) : unit(diagonal_of(covariance)) {
    const double largest = *std::ranges::max_element(unit);
    for (double& u : unit) u = 1.0 / std::sqrt(std::max({u, least_of_largest * largest, 1e-300}));
    Matrix scaled_covariance = scaled_rows(unit, scaled_columns(covariance, unit));
    for (std::size_t i = 0; i < unit.size(); ++i) scaled_covariance(i, i) += added_to_unit;
    root = cholesky(scaled_covariance).lower;
  }
  Matrix operator()(const Matrix& a) const { return solve_lower(root, scaled_rows(unit, a)); }
  std::vector<double> operator()(const std::vector<double>& b) const { return solve_lower(root, scaled(unit, b)); }
};

/// The columns of unit length, and 1 over their lengths; a column of zeros stays.
std::pair<Matrix, std::vector<double>> even_columns(Matrix x) {
  std::vector<double> size = inverses(column_norms(x));
  for (double& s : size)
    if (!std::isfinite(s)) s = 0.0;
  return {scaled_columns(std::move(x), size), size};
}

}  // namespace

double chance_of_ratio(double ratio, double freedom, double error_freedom) {
  using namespace boost::math;
  if (!(ratio > 0.0)) return 1.0;
  if (!std::isfinite(ratio)) return 0.0;
  if (std::isinf(error_freedom)) return cdf(complement(chi_squared_distribution<double>(freedom), ratio * freedom));
  return cdf(complement(fisher_f_distribution<double>(freedom, error_freedom), ratio));
}

Matrix indicators(const std::vector<std::size_t>& group) {
  std::vector<std::size_t> names = group;
  std::ranges::sort(names);
  names.erase(std::ranges::unique(names).begin(), names.end());
  Matrix out(group.size(), names.size());
  for (std::size_t i = 0; i < group.size(); ++i)
    out(i, static_cast<std::size_t>(std::ranges::lower_bound(names, group[i]) - names.begin())) = 1.0;
  return out;
}

LackOfFit lack_of_fit(const Matrix& design, const Matrix& more, const std::vector<double>& observations,
                      const Matrix& covariance, double error_freedom) {
  LackOfFit out;
  const Whitener white(covariance);
  const auto y = white(observations);
  const Matrix x = white(design), added = white(more);
  const auto [model, size] = even_columns(x);
  const auto [both, all_sizes] = even_columns(beside(x, added));
  const QrFit without = qr_fit(model, y, same_column), with = qr_fit(both, y, same_column);
  if (with.rank <= without.rank) return out;
  out.freedom = static_cast<double>(with.rank - without.rank);
  const double remaining = static_cast<double>(y.size() - with.rank);
  const double explained = std::max(0.0, without.residual_square - with.residual_square) / out.freedom;
  out.error_freedom = error_freedom > 0.0 ? error_freedom : remaining;
  if (more.columns == 1) {
    const double scale = all_sizes.back();
    out.coefficient = with.x.back() * scale;
    out.sd = norm(row(with.root, with.root.rows - 1)) * scale;
  }
  if (!(out.error_freedom > 0.0)) return out;
  if (error_freedom > 0.0) {
    out.ratio = explained;
  } else {
    // what rounding leaves is no error with which anything can be compared
    const double floor = 1e-24 * dot(y, y);
    out.ratio = explained / std::max(with.residual_square / remaining, floor);
    if (!(explained > floor)) out.ratio = 0.0;
  }
  out.probability = chance_of_ratio(out.ratio, out.freedom, out.error_freedom);
  return out;
}

}  // namespace tumble
