#include "tumble/methods/accelerometer_four_position/components.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"

namespace tumble::accelerometer_four_position {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// z'PK_iPz, tr(PK_i) and tr(PK_iPK_j)/2 on the contrasts, P = V^-1.
struct Point {
  VectorXd fits, expects;
  MatrixXd information;
};

Point point_at(const VectorXd& variance, const VectorXd& z, const MatrixXd& known,
               const std::vector<MatrixXd>& kernels) {
  MatrixXd v = known;
  for (std::size_t c = 0; c < kernels.size(); ++c) v += variance[at(c)] * kernels[c];
  const MatrixXd inverse = v.ldlt().solve(MatrixXd::Identity(v.rows(), v.cols()));
  const VectorXd white = inverse * z;
  const Index n = at(kernels.size());
  Point point{VectorXd(n), VectorXd(n), MatrixXd(n, n)};
  std::vector<MatrixXd> passed;
  for (const auto& kernel : kernels) passed.push_back(inverse * kernel);
  for (Index i = 0; i < n; ++i) {
    const auto& one = passed[static_cast<std::size_t>(i)];
    point.fits[i] = white.dot(kernels[static_cast<std::size_t>(i)] * white);
    point.expects[i] = one.trace();
    for (Index j = 0; j < n; ++j)
      point.information(i, j) = 0.5 * one.cwiseProduct(passed[static_cast<std::size_t>(j)].transpose()).sum();
  }
  return point;
}

}  // namespace

Components components_of(const Matrix& design, const std::vector<double>& z_in, const Matrix& known_in,
                         const std::vector<Matrix>& kernels_in) {
  const Index n = at(design.rows), p = at(design.columns), m = n - p, count = at(kernels_in.size());
  const MatrixXd q = MatrixXd(map(design).householderQr().householderQ()).rightCols(m);
  const VectorXd z = q.transpose() * Eigen::Map<const VectorXd>(z_in.data(), n);
  MatrixXd known = q.transpose() * map(known_in) * q;
  std::vector<MatrixXd> kernels;
  for (const auto& kernel : kernels_in) kernels.push_back(q.transpose() * map(kernel) * q);

  const double mean = z.squaredNorm() / static_cast<double>(m);
  const double floor = std::max({1e-9 * mean, 1e-9 * known.diagonal().mean(), 1e-300});
  known.diagonal().array() += floor;
  VectorXd variance(count);
  for (Index c = 0; c < count; ++c)
    variance[c] = std::max(mean, floor) * static_cast<double>(m) /
                  std::max(1e-30, kernels[static_cast<std::size_t>(c)].trace()) / static_cast<double>(count);
  // Multiplicative steps never lead downhill (Zhou, Hu, Zhou and Lange, J. Comput. Graph. Stat. 28 (2019) 350).
  for (int round = 0; round < 400; ++round) {
    const Point point = point_at(variance, z, known, kernels);
    const VectorXd next = variance.cwiseProduct(point.fits.cwiseQuotient(point.expects.cwiseMax(1e-300)).cwiseSqrt());
    const bool still = (next - variance).cwiseAbs().maxCoeff() < 1e-8 * variance.maxCoeff();
    variance = next;
    if (still) break;
  }
  const double scale = known.diagonal().mean() + variance.sum();
  for (Index c = 0; c < count; ++c)
    if (variance[c] < 1e-4 * scale) variance[c] = 0.0;
  const MatrixXd information = point_at(variance, z, known, kernels).information;
  const VectorXd unit =
      information.diagonal().cwiseSqrt().cwiseInverse().unaryExpr([](double u) { return std::isfinite(u) ? u : 0.0; });
  const MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  const MatrixXd inverse = scaled.completeOrthogonalDecomposition().pseudoInverse();
  return {{variance.data(), variance.data() + count}, plain(unit.asDiagonal() * inverse * unit.asDiagonal())};
}

}  // namespace tumble::accelerometer_four_position
