#include "tumble/math/regression/mixed_model/rows.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tumble/math/eigen/view.hpp"
#include "tumble/units/error.hpp"

namespace tumble::mixed_model {
namespace {

constexpr double least_column = 1e-9;   ///< [1] in unit columns: the means of the rows do not distinguish them
constexpr double share_of_means = 0.9;  ///< [1] of the information, that the means of the rows must hold
constexpr double no_account = 0.01;     ///< [1] of the white noise of one row: a known effect below it has none
constexpr double least_pivot = 1e-12;   ///< [1] of the first: parameters that are not distinguished

/// Rows of one segment: [X | D | 1], whitened, and y.
struct Block {
  MatrixXd model;
  VectorXd observations;
};

constexpr double rounding = 1e-13;

/// Turns a segment's rows so that all but the first few vanish: pivoted Householder QR of the columns over `scale`.
/// Returns how many remain; what is below `rounding` is left out.
Index compress(Block& block, const VectorXd& scale) {
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(block.model * scale.cwiseInverse().asDiagonal());
  const auto diagonal = qr.matrixQR().diagonal().cwiseAbs();
  Index rank = 0;
  while (rank < diagonal.size() && diagonal[rank] > rounding) ++rank;
  const Index n = block.model.rows();
  MatrixXd r = qr.matrixQR().topRows(rank).triangularView<Eigen::Upper>();
  block.model = r * qr.colsPermutation().transpose() * scale.asDiagonal();
  block.observations.applyOnTheLeft(qr.householderQ().setLength(std::min(n, qr.matrixQR().cols())).transpose());
  return rank;
}

/// Whether the means of as many segments as parameters hold at least 0.9 of the information about any combination of
/// parameters.
bool means_say_all(const MatrixXd& design, const MatrixXd& means) {
  const Index p = design.cols();
  if (means.rows() != p || design.rows() == p) return false;
  const VectorXd scale = design.colwise().norm();
  if (!(scale.minCoeff() > 0.0)) return false;
  const Eigen::HouseholderQR<MatrixXd> qr(design * scale.cwiseInverse().asDiagonal());
  const MatrixXd r = qr.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  if (r.diagonal().cwiseAbs().minCoeff() < least_column) return false;
  const MatrixXd share =
      r.transpose().triangularView<Eigen::Lower>().solve((means * scale.cwiseInverse().asDiagonal()).transpose());
  return Eigen::JacobiSVD<MatrixXd>(share).singularValues()[p - 1] > std::sqrt(share_of_means);
}

/// The rows of a segment along its mean, one a segment; what remains of the observations shows the noise.
void keep_means(Compressed& rows) {
  const Index segments = at(rows.parts.size());
  MatrixXd along = MatrixXd::Zero(rows.design.rows(), segments);
  for (Index g = 0; g < segments; ++g) along.col(g) = rows.incidence.col(g).normalized();
  const MatrixXd design = along.transpose() * rows.design;
  if (!means_say_all(rows.design, design)) return;
  const VectorXd means = along.transpose() * rows.observations;
  const VectorXd b = design.colPivHouseholderQr().solve(means);
  const VectorXd rest = rows.observations - rows.design * b;
  rows.within_squares += (rest - along * (along.transpose() * rest)).squaredNorm();
  rows.within_freedom += static_cast<double>(rows.design.rows() - segments);
  rows.design = design;
  rows.observations = means;
  rows.effects = along.transpose() * rows.effects;
  rows.incidence = along.transpose() * rows.incidence;
  for (Index g = 0; g < segments; ++g) rows.parts[static_cast<std::size_t>(g)] = {g, 1};
}

}  // namespace

double scatter_within(const MixedData& data) {
  double least = std::numeric_limits<double>::infinity();
  const std::size_t n = data.segment.size();
  for (std::size_t first = 0, last = 0; first < n; first = last) {
    double weight = 0.0, sum = 0.0, squares = 0.0;
    for (; last < n && data.segment[last] == data.segment[first]; ++last)
      weight += data.weights[last], sum += data.weights[last] * data.observations[last];
    if (last - first < 4) continue;
    for (std::size_t i = first; i < last; ++i) squares += data.weights[i] * square(data.observations[i] - sum / weight);
    least = std::min(least, squares / static_cast<double>(last - first - 1));
  }
  return std::isfinite(least) ? std::sqrt(least) : 0.0;
}

namespace {

/// All columns, times the roots of the weights: the design, the known effects, and ones. The scale of each.
struct WeightedColumns {
  MatrixXd model;
  VectorXd scale;
};

WeightedColumns weighted_columns(const MixedData& data, const VectorXd& root, double white) {
  const Index n = at(data.design.rows), p = at(data.design.columns), q = at(data.effects.size());
  MatrixXd model(n, p + q + 1);
  model.leftCols(p) = map(data.design);
  for (Index k = 0; k < q; ++k)
    model.col(p + k) = Eigen::Map<const VectorXd>(data.effects[static_cast<std::size_t>(k)].column.data(), n);
  model.col(p + q).setOnes();
  model = root.asDiagonal() * model;
  VectorXd scale = model.colwise().norm();
  for (auto& s : scale)
    if (!(s > 0.0)) s = 1.0;
  // What a known effect does beyond the columns is of no account below a hundredth of the white noise of one row.
  for (Index k = 0; k < q; ++k) scale[p + k] = std::max(scale[p + k], no_account * white / rounding);
  return {std::move(model), std::move(scale)};
}

}  // namespace

Compressed compress(const MixedData& data, double white) {
  const Index n = at(data.design.rows), p = at(data.design.columns), q = at(data.effects.size());
  const VectorXd root = Eigen::Map<const VectorXd>(data.weights.data(), n).cwiseSqrt();
  const auto [model, scale] = weighted_columns(data, root, white);
  VectorXd y = VectorXd::Zero(n);
  if (!data.observations.empty()) y = root.cwiseProduct(Eigen::Map<const VectorXd>(data.observations.data(), n));

  Compressed out;
  for (const auto& effect : data.effects) out.each_segment.push_back(effect.each_segment);
  MatrixXd rows(n, p + q + 1);
  VectorXd kept(n);
  Index used = 0;
  for (Index first = 0, last = 0; first < n; first = last) {
    while (last < n && data.segment[static_cast<std::size_t>(last)] == data.segment[static_cast<std::size_t>(first)])
      ++last;
    Block block{model.middleRows(first, last - first), y.segment(first, last - first)};
    const Index rank = compress(block, scale);
    rows.middleRows(used, rank) = block.model;
    kept.segment(used, rank) = block.observations.head(rank);
    out.within_squares += block.observations.tail(last - first - rank).squaredNorm();
    out.within_freedom += static_cast<double>(last - first - rank);
    out.parts.emplace_back(used, rank);
    used += rank;
  }
  out.design = rows.topLeftCorner(used, p);
  out.effects = rows.block(0, p, used, q);
  out.observations = kept.head(used);
  out.incidence = MatrixXd::Zero(used, at(out.parts.size()));
  for (std::size_t g = 0; g < out.parts.size(); ++g) {
    const auto [first, count] = out.parts[g];
    out.incidence.col(at(g)).segment(first, count) = rows.col(p + q).segment(first, count);
  }
  keep_means(out);
  return out;
}

std::pair<VectorXd, VectorXd> ordinary(const Compressed& rows) {
  const Index p = rows.design.cols();
  const VectorXd scale = rows.design.colwise().norm();
  if (rows.design.rows() < p || !(scale.minCoeff() > 0.0))
    throw Error(Error::Kind::bad_data,
                say("{} independent observations cannot determine {} parameters", rows.design.rows(), p));
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(rows.design * scale.cwiseInverse().asDiagonal());
  if (std::abs(qr.matrixQR()(p - 1, p - 1)) < least_pivot * std::abs(qr.matrixQR()(0, 0)))
    throw Error(Error::Kind::bad_data, "the observations cannot distinguish the parameters");
  const VectorXd b = scale.cwiseInverse().cwiseProduct(qr.solve(rows.observations));
  return {b, rows.observations - rows.design * b};
}

MatrixXd known_factor(const Compressed& rows) {
  const Index n = rows.design.rows();
  std::vector<VectorXd> columns;
  for (Index k = 0; k < rows.effects.cols(); ++k) {
    if (!rows.each_segment[static_cast<std::size_t>(k)]) {
      columns.emplace_back(rows.effects.col(k));
      continue;
    }
    for (const auto& [first, count] : rows.parts) {
      columns.emplace_back(VectorXd::Zero(n));
      columns.back().segment(first, count) = rows.effects.col(k).segment(first, count);
    }
  }
  MatrixXd factor(n, at(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) factor.col(at(c)) = columns[c];
  return factor;
}

MatrixXd known_covariance(const Compressed& rows) {
  MatrixXd v = MatrixXd::Zero(rows.design.rows(), rows.design.rows());
  for (Index k = 0; k < rows.effects.cols(); ++k) {
    if (!rows.each_segment[static_cast<std::size_t>(k)]) {
      v += rows.effects.col(k) * rows.effects.col(k).transpose();
      continue;
    }
    for (const auto& [first, count] : rows.parts) {
      const auto d = rows.effects.col(k).segment(first, count);
      v.block(first, first, count, count) += d * d.transpose();
    }
  }
  return v;
}

}  // namespace tumble::mixed_model
