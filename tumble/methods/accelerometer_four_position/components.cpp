#include "tumble/methods/accelerometer_four_position/components.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/math/linear_algebra.hpp"

namespace tumble::accelerometer_four_position {
namespace {

/// [1] of the greatest eigenvalue, above which another counts for the rank: those of a smaller rank are rounding.
constexpr double least_eigenvalue = 1e-9;
/// [1] of the mean square and of the known variance, which is added so that the matrix is regular without noise.
constexpr double variance_floor = 1e-9;
constexpr int most_steps = 400;          ///< the trials need fewer than 100
constexpr double last_change = 1e-8;     ///< [1] of the greatest variance, after which the steps end
constexpr double least_variance = 1e-4;  ///< [1] of all together, below which a component is none: 1 % of their sd

/// z'PK_iPz, tr(PK_i) and tr(PK_iPK_j)/2 on the contrasts, P = V^-1.
struct Point {
  std::vector<double> fits, expects;
  Matrix information;
};

Point point_at(const std::vector<double>& variance, const std::vector<double>& z, const Matrix& known,
               const std::vector<Matrix>& kernels) {
  Matrix v = known;
  for (std::size_t c = 0; c < kernels.size(); ++c) v += variance[c] * kernels[c];
  const Matrix inverse = inverse_symmetric(v);
  const auto white = inverse * z;
  Point point{{}, {}, Matrix(kernels.size(), kernels.size())};
  std::vector<Matrix> products;
  for (const auto& kernel : kernels) products.push_back(inverse * kernel);
  for (std::size_t i = 0; i < kernels.size(); ++i) {
    point.fits.push_back(quadratic_form(white, kernels[i]));
    point.expects.push_back(trace(products[i]));
    for (std::size_t j = 0; j < kernels.size(); ++j)
      point.information(i, j) = 0.5 * dot(products[i].values, transposed(products[j]).values);
  }
  return point;
}

/// Covariance [c x c] of the variances from their information; 0 for one that is zero or of which the data show
/// nothing.
Matrix covariance_from(const Matrix& information, const std::vector<double>& variance) {
  auto unit = diagonal_of(information);
  for (std::size_t c = 0; c < unit.size(); ++c)
    unit[c] = variance[c] > 0.0 && unit[c] > 0.0 ? 1.0 / std::sqrt(unit[c]) : 0.0;
  const auto scale = [&](const Matrix& m) { return scaled_rows(unit, scaled_columns(m, unit)); };
  return scale(pseudo_inverse(scale(information)));
}

/// Given: kernels K_c [m x m] on the contrasts.
std::vector<double> freedom_by_rank(const std::vector<Matrix>& kernels, const std::vector<double>& variance) {
  std::vector<double> rank;
  for (const auto& kernel : kernels) {
    const auto values = eigenvalues_symmetric(kernel);
    rank.push_back(static_cast<double>(
        std::ranges::count_if(values, [&](double value) { return value > least_eigenvalue * values.back(); })));
  }
  std::vector<double> out = rank;
  for (std::size_t c = 0; c < kernels.size(); ++c) {
    if (rank[c] == static_cast<double>(kernels[c].rows))
      for (std::size_t other = 0; other < kernels.size(); ++other)
        if (other != c && variance[other] > 0.0) out[c] -= rank[other];
    out[c] = std::max(1.0, out[c]);
  }
  return out;
}

double mean_of_diagonal(const Matrix& a) { return trace(a) / static_cast<double>(a.rows); }

}  // namespace

Components components_of(const Matrix& design, const std::vector<double>& observations, const Matrix& covariance,
                         const std::vector<Matrix>& all_kernels) {
  const std::size_t n = design.rows, m = n - design.columns, count = all_kernels.size();
  const Matrix contrasts = transposed(q_product(householder_qr(design), block(identity(n), 0, n, design.columns, m)));
  const auto z = contrasts * observations;
  Matrix known = sandwich(contrasts, covariance);
  std::vector<Matrix> kernels;
  for (const auto& kernel : all_kernels) kernels.push_back(sandwich(contrasts, kernel));

  const double mean = dot(z, z) / static_cast<double>(m);
  const double floor = std::max({variance_floor * mean, variance_floor * mean_of_diagonal(known), 1e-300});
  for (std::size_t i = 0; i < m; ++i) known(i, i) += floor;
  std::vector<double> variance;
  for (const auto& kernel : kernels)
    variance.push_back(std::max(mean, floor) * static_cast<double>(m) / std::max(1e-30, trace(kernel)) /
                       static_cast<double>(count));
  // Multiplicative steps never lead downhill (Zhou, Hu, Zhou and Lange, J. Comput. Graph. Stat. 28 (2019) 350).
  for (int round = 0; round < most_steps; ++round) {
    const Point point = point_at(variance, z, known, kernels);
    double step = 0.0;
    for (std::size_t c = 0; c < count; ++c) {
      const double next = variance[c] * std::sqrt(std::max(0.0, point.fits[c]) / std::max(point.expects[c], 1e-300));
      step = std::max(step, std::abs(next - variance[c]));
      variance[c] = next;
    }
    if (step < last_change * std::ranges::max(variance)) break;
  }
  const double scale = std::accumulate(variance.begin(), variance.end(), mean_of_diagonal(known));
  for (double& v : variance)
    if (v < least_variance * scale) v = 0.0;
  return {variance, covariance_from(point_at(variance, z, known, kernels).information, variance),
          freedom_by_rank(kernels, variance)};
}

}  // namespace tumble::accelerometer_four_position
