#include "tumble/core/budget.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/symmetric_factor.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Zeros are skipped: an infinite uncertainty of one parameter says nothing of the others.
void add_products(const Matrix& factor, Matrix& sum) {
  for (std::size_t c = 0; c < factor.columns; ++c)
    for (std::size_t i = 0; i < factor.rows; ++i) {
      if (factor(i, c) == 0.0) continue;
      for (std::size_t j = 0; j <= i; ++j)
        if (factor(j, c) != 0.0) sum(i, j) += factor(i, c) * factor(j, c);
    }
}

void mirror(Matrix& sum) {
  for (std::size_t i = 0; i < sum.rows; ++i)
    for (std::size_t j = 0; j < i; ++j) sum(j, i) = sum(i, j);
}

bool finite(const Matrix& m) {
  return std::ranges::all_of(m.values, [](double v) { return std::isfinite(v); });
}

}  // namespace

Matrix covariance_of(const std::vector<Contribution>& budget, std::size_t parameters) {
  Matrix sum(parameters, parameters);
  for (const auto& line : budget) {
    if (line.factor.rows != parameters)
      throw Error(Error::Kind::internal, say("budget line '{}' has not one row a parameter", line.source));
    add_products(line.factor, sum);
  }
  mirror(sum);
  return sum;
}

Contribution independent_errors(std::string source, const std::vector<double>& variance) {
  Contribution line{std::move(source), {}, Matrix(variance.size(), 0)};
  for (std::size_t i = 0; i < variance.size(); ++i) {
    if (variance[i] == 0.0) continue;
    std::vector<double> column(variance.size(), 0.0);
    column[i] = std::sqrt(variance[i]);
    line.factor.values.insert(line.factor.values.end(), column.begin(), column.end());
    ++line.factor.columns;
  }
  return line;
}

Matrix narrowed(Matrix factor) {
  if (factor.columns <= factor.rows || !finite(factor)) return factor;
  Matrix sum(factor.rows, factor.rows);
  add_products(factor, sum);
  mirror(sum);
  return symmetric_factor(sum).factor;
}

void gather_small(Estimate& estimate) {
  constexpr double least_share = 1e-3;
  const std::size_t p = estimate.parameters.size();
  Contribution small{"all other errors", {}, Matrix(p, 0)};
  std::erase_if(estimate.budget, [&](const Contribution& line) {
    double most = 0.0;
    for (std::size_t i = 0; i < p; ++i) most = std::max(most, line.variance(i) / estimate.covariance(i, i));
    if (most >= least_share || (most > 0.0 && !line.key.empty())) return false;
    if (most > 0.0) {
      small.factor.values.insert(small.factor.values.end(), line.factor.values.begin(), line.factor.values.end());
      small.factor.columns += line.factor.columns;
    }
    return true;
  });
  if (small.factor.columns == 0) return;
  small.factor = narrowed(std::move(small.factor));
  estimate.budget.push_back(std::move(small));
}

}  // namespace tumble
