#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/population/components/likelihood.hpp"
#include "tumble/math/square.hpp"

namespace tumble::components {
namespace {

/// V [n x n] at these variances.
Matrix covariance_of(const Model& model, const std::vector<double>& variances) {
  const auto n = model.values.size();
  Matrix v(n, n);
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < model.shared.columns; ++k) v(i, j) += model.shared(i, k) * model.shared(j, k);
      for (std::size_t c = 0; c < model.levels.size(); ++c)
        if (model.levels[c][i] == model.levels[c][j]) v(i, j) += variances[c];
    }
  for (std::size_t i = 0; i < n; ++i) v(i, i) += model.own[i] + variances.back();
  return v;
}

/// Z_a' P Z_b [levels of a x levels of b].
Matrix grouped(const Matrix& p, const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) {
  const auto count = [](const std::vector<std::size_t>& levels) { return std::ranges::max(levels) + 1; };
  Matrix out(count(a), count(b));
  for (std::size_t j = 0; j < p.columns; ++j)
    for (std::size_t i = 0; i < p.rows; ++i) out(a[i], b[j]) += p(i, j);
  return out;
}

double sum_of_squares(const Matrix& a) {
  double sum = 0.0;
  for (const double value : a.values) sum += square(value);
  return sum;
}

void add_scores(const Model& model, const Matrix& p, const std::vector<double>& py, AtVariances& out) {
  auto levels = model.levels;
  auto& each = levels.emplace_back(model.values.size());
  std::iota(each.begin(), each.end(), std::size_t{0});
  out.information = Matrix(levels.size(), levels.size());
  for (std::size_t c = 0; c < levels.size(); ++c) {
    const Matrix own = grouped(p, levels[c], levels[c]);
    std::vector<double> sums(own.rows);
    for (std::size_t i = 0; i < py.size(); ++i) sums[levels[c][i]] += py[i];
    out.score.push_back(0.5 * (dot(sums, sums) - trace(own)));
    for (std::size_t d = 0; d <= c; ++d)
      out.information(c, d) = out.information(d, c) = 0.5 * sum_of_squares(grouped(p, levels[c], levels[d]));
  }
}

}  // namespace

AtVariances dense_at(const Model& model, const std::vector<double>& variances) {
  const auto n = model.values.size();
  const auto factor = cholesky(covariance_of(model, variances));
  AtVariances out;
  if (!factor.positive) {
    out.log_likelihood = -INFINITY;
    return out;
  }
  out.weights = solve(factor, std::vector<double>(n, 1.0));
  const double sum = std::accumulate(out.weights.begin(), out.weights.end(), 0.0);
  out.mean_variance = 1.0 / sum;
  out.mean = dot(out.weights, model.values) / sum;
  std::vector<double> residual = model.values;
  for (auto& value : residual) value -= out.mean;
  const auto py = solve(factor, residual);  // P y
  out.log_likelihood = -0.5 * (factor.log_determinant + std::log(sum) + dot(residual, py));
  Matrix p = solve(factor, identity(n));
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i) p(i, j) -= out.weights[i] * out.weights[j] / sum;
  add_scores(model, p, py, out);
  return out;
}

}  // namespace tumble::components
