#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "tumble/math/eigen/view.hpp"
#include "tumble/math/regression/mixed_model.hpp"

namespace tumble {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double part_of_dependence = 1e-3;  ///< [1] of a direction that has no length, in which a column takes part
constexpr double stated_weight = 3.0;        ///< [limit of the condition] a smaller weight is rounding

/// The next column to leave out: the first in the order of preference that takes part in a null vector.
Index next_to_drop(const MatrixXd& scaled, const std::vector<Index>& kept, const std::vector<Index>& order,
                   double limit) {
  const Eigen::JacobiSVD<MatrixXd> svd(scaled(Eigen::all, kept), Eigen::ComputeThinV);
  const VectorXd& s = svd.singularValues();
  Index rank = 0;
  while (rank < s.size() && s[rank] * limit > s[0]) ++rank;
  if (rank == at(kept.size())) return -1;
  // Columns orthogonal to the null space have only rounding in it; 0.001 keeps those out that are nearly so.
  const VectorXd share = svd.matrixV().rightCols(at(kept.size()) - rank).rowwise().norm();
  for (const Index column : order) {
    const auto found = std::ranges::find(kept, column);
    if (found != kept.end() && share[found - kept.begin()] > part_of_dependence) return column;
  }
  return kept.back();
}

}  // namespace

std::vector<Dropped> unobservable_columns(const Matrix& design, const std::vector<double>& weights,
                                          const std::vector<double>& natural,
                                          const std::vector<std::size_t>& preference, double limit) {
  const Index p = at(design.columns);
  const VectorXd w = Eigen::Map<const VectorXd>(weights.data(), at(weights.size()));
  MatrixXd scaled = w.cwiseSqrt().asDiagonal() * map(design);
  if (scaled.rows() > p)
    scaled = MatrixXd(Eigen::HouseholderQR<MatrixXd>(scaled).matrixQR().topRows(p).triangularView<Eigen::Upper>());
  if (scaled.rows() < p) scaled.conservativeResizeLike(MatrixXd::Zero(p, p));  // so that V holds all null vectors
  const VectorXd norms = scaled.colwise().norm();
  std::vector<Index> order, kept, dropped;
  for (const auto column : preference) order.push_back(at(column));
  for (Index j = p - 1; j >= 0; --j)
    if (std::ranges::find(order, j) == order.end()) order.push_back(j);
  for (Index j = 0; j < p; ++j) {
    const double size = natural.empty() ? 0.0 : natural[static_cast<std::size_t>(j)] * std::sqrt(w.sum());
    const bool empty = !(norms[j] > 0.0) || norms[j] * limit < size;
    (empty ? dropped : kept).push_back(j);
    if (norms[j] > 0.0) scaled.col(j) /= norms[j];
  }
  const auto empty = dropped.size();
  for (Index next; !kept.empty() && (next = next_to_drop(scaled, kept, order, limit)) >= 0;) {
    std::erase(kept, next);
    dropped.push_back(next);
  }
  std::vector<Dropped> result;
  for (std::size_t d = 0; d < dropped.size(); ++d) {
    result.push_back({static_cast<std::size_t>(dropped[d]), std::vector<double>(design.columns, 0.0)});
    if (d < empty || kept.empty()) continue;
    const VectorXd share = scaled(Eigen::all, kept).colPivHouseholderQr().solve(scaled.col(dropped[d]));
    for (std::size_t k = 0; k < kept.size(); ++k)
      if (std::abs(share[at(k)]) > stated_weight / limit)
        result.back().weights[static_cast<std::size_t>(kept[k])] = share[at(k)] * norms[dropped[d]] / norms[kept[k]];
  }
  return result;
}

}  // namespace tumble
