#include "tumble/math/regression/added_terms.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/eigen/view.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/math/square.hpp"

namespace tumble {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// [1] of the square of a column, that the model must leave of it: the rest is rounding, or the errors of the axes.
constexpr double least_left = 1e-6;
constexpr double rounding_of_mean = 1e-24;   ///< [1] of the square of a column: it does not change within the segments
constexpr double pivot_of_rounding = 1e-12;  ///< [1] of the square of a column: it is a sum of others

/// One test, from the squares that remain without and with the candidate.
AddedTerm added_term(double without, double explained, double freedom, double coefficient) {
  AddedTerm term{.coefficient = coefficient};
  if (!(freedom > 0.0 && without > 0.0)) return term;
  const double with = std::max(without - explained, 1e-15 * without);
  term.error_freedom = freedom;
  term.explained = explained / without;
  term.ratio = explained / (with / freedom);
  term.probability = chance_of_ratio(term.ratio, 1.0, freedom);
  term.gain = 0.5 * (freedom + 1.0) * std::log(without / with);
  return term;
}

/// Rows [first, last) of one segment: [X | effects that all share | residual | candidates], each less its mean, in units of
/// the white noise.
MatrixXd about_means(const MatrixXd& all, const VectorXd& roots, Index first, Index count) {
  const VectorXd root = roots.segment(first, count);
  MatrixXd part = root.asDiagonal() * all.middleRows(first, count);
  const VectorXd unit = root.normalized();
  part -= unit * (unit.transpose() * part);
  return part;
}

/// A' V^-1 A of the rows of one segment with effects of its own, whose columns U have unit variance.
MatrixXd with_own_effects(const MatrixXd& a, const MatrixXd& u) {
  if (u.cols() == 0) return a.transpose() * a;
  const MatrixXd cross = u.transpose() * a;
  const MatrixXd inner = u.transpose() * u + MatrixXd::Identity(u.cols(), u.cols());
  return a.transpose() * a - cross.transpose() * inner.llt().solve(cross);
}

/// Takes the columns before `end` out of a matrix of products. Returned: how many of them, from `free` on, are no sums of
/// others.
Index swept(MatrixXd& products, Index free, Index end) {
  const VectorXd before = products.diagonal();
  Index rank = 0;
  for (Index j = 0; j < end; ++j) {
    const double pivot = products(j, j);
    if (!(pivot > pivot_of_rounding * before[j])) continue;
    const VectorXd column = products.col(j);
    products -= column * (column.transpose() / pivot);
    if (j >= free) ++rank;
  }
  return rank;
}

struct EffectColumns {
  MatrixXd shared, own;  ///< effects that all segments share, and those drawn anew for each
};

EffectColumns columns_of_effects(const MixedData& data, double white) {
  const Index n = at(data.weights.size());
  EffectColumns out;
  const auto count = std::ranges::count(data.effects, true, &KnownEffect::each_segment);
  out.own.resize(n, count);
  out.shared.resize(n, at(data.effects.size()) - count);
  Index own = 0, shared = 0;
  for (const KnownEffect& effect : data.effects) {
    const VectorXd column = map(std::span(effect.column)) / std::sqrt(white);
    if (effect.each_segment)
      out.own.col(own++) = column;
    else
      out.shared.col(shared++) = column;
  }
  return out;
}

/// The squares and products within the segments of two rows and more, and the number of rows less that of segments.
struct ProductsWithin {
  MatrixXd all;
  double freedom = 0.0;
};

ProductsWithin products_within(const MixedData& data, const MatrixXd& all, const MatrixXd& own) {
  ProductsWithin out{MatrixXd::Zero(all.cols(), all.cols()), 0.0};
  const VectorXd roots = map(std::span(data.weights)).cwiseSqrt();
  for (std::size_t first = 0, last = 0; first < data.segment.size(); first = last) {
    while (last < data.segment.size() && data.segment[last] == data.segment[first]) ++last;
    const Index count = at(last - first);
    if (count < 2) continue;
    MatrixXd u = about_means(own, roots, at(first), count);
    std::vector<Index> felt;
    for (Index k = 0; k < u.cols(); ++k)
      if (u.col(k).squaredNorm() > 0.0) felt.push_back(k);
    out.all += with_own_effects(about_means(all, roots, at(first), count), u(Eigen::all, felt));
    out.freedom += static_cast<double>(count) - 1.0;
  }
  return out;
}

}  // namespace

std::vector<AddedTerm> added_within_segments(const MixedData& data, const std::vector<double>& residuals,
                                             const Matrix& candidates, double white_variance) {
  const Index n = at(residuals.size()), p = at(data.design.columns), m = at(candidates.columns);
  std::vector<AddedTerm> terms(candidates.columns);
  if (!(white_variance > 0.0)) return terms;
  const EffectColumns effects = columns_of_effects(data, white_variance);
  const Index k = effects.shared.cols(), end = k + p;
  MatrixXd all(n, end + 1 + m);
  all << effects.shared, map(data.design), map(std::span(residuals)) / std::sqrt(white_variance), map(candidates);
  auto [products, freedom] = products_within(data, all, effects.own);
  products.diagonal().head(k).array() += 1.0;
  const VectorXd before = products.diagonal();
  const VectorXd whole = map(candidates).cwiseAbs2().transpose() * map(std::span(data.weights));
  const Index rank = swept(products, k, end);
  for (Index j = 0; j < m; ++j) {
    const Index at_column = end + 1 + j;
    const double square = products(at_column, at_column), cross = products(end, at_column);
    if (!(square > least_left * before[at_column]) || !(before[at_column] > rounding_of_mean * whole[j])) continue;
    terms[static_cast<std::size_t>(j)] =
        added_term(products(end, end), cross * cross / square, freedom - static_cast<double>(rank) - 1.0,
                   cross / square * std::sqrt(white_variance));
  }
  return terms;
}

SegmentMeans segment_means(const MixedData& data, const std::vector<double>& residuals, const Matrix& candidates,
                           double white_variance) {
  const Index segments = data.segment.empty() ? 0 : at(data.segment.back() + 1), p = at(data.design.columns);
  const Index m = at(candidates.columns), k = at(data.effects.size());
  MatrixXd all(at(residuals.size()), p + m + 1 + k);
  all.leftCols(p + m + 1) << map(data.design), map(candidates), map(std::span(residuals));
  for (Index e = 0; e < k; ++e)
    all.col(p + m + 1 + e) = map(std::span(data.effects[static_cast<std::size_t>(e)].column));
  VectorXd time = VectorXd::Zero(segments);
  MatrixXd mean = MatrixXd::Zero(segments, all.cols());
  for (std::size_t i = 0; i < data.weights.size(); ++i) {
    time[at(data.segment[i])] += data.weights[i];
    mean.row(at(data.segment[i])) += data.weights[i] * all.row(at(i));
  }
  mean = time.cwiseInverse().asDiagonal() * mean;
  SegmentMeans means{.design = plain(mean.leftCols(p)), .candidates = plain(mean.middleCols(p, m))};
  for (Index g = 0; g < segments; ++g) {
    means.left.push_back(mean(g, p + m));
    means.white.push_back(white_variance / time[g]);
  }
  MatrixXd known = MatrixXd::Zero(segments, segments);
  for (Index e = 0; e < k; ++e) {
    const VectorXd column = mean.col(p + m + 1 + e);
    if (data.effects[static_cast<std::size_t>(e)].each_segment)
      known.diagonal() += column.cwiseAbs2();
    else
      known += column * column.transpose();
  }
  for (const SlowNoise& slow : data.slow)
    if (slow.known)
      known += slow.variance * map(slow.kernel);
    else
      means.kernels.push_back(slow.kernel);
  means.known = plain(known);
  return means;
}

namespace {

/// The best of some sizes of slow noise for each candidate.
struct BestSize {
  AddedTerm term;
  double criterion = std::numeric_limits<double>::infinity();
};

/// The candidates with one covariance of the means.
void try_covariance(const SegmentMeans& means, const MatrixXd& covariance, std::vector<BestSize>& best) {
  const Eigen::LLT<MatrixXd> root(covariance);
  if (root.info() != Eigen::Success) return;
  const auto white = [&](MatrixXd a) -> MatrixXd {
    root.matrixL().solveInPlace(a);
    return a;
  };
  const Eigen::ColPivHouseholderQR<MatrixXd> model(white(map(means.design)));
  const Index rank = model.rank(), n = at(means.left.size());
  const double freedom = static_cast<double>(n - rank) - 1.0;
  if (!(freedom > 0.0)) return;
  const auto beyond = [&](const MatrixXd& a) -> MatrixXd {
    MatrixXd turned = model.householderQ().transpose() * a;
    turned.topRows(rank).setZero();
    return turned;
  };
  const MatrixXd candidates = white(map(means.candidates)), left = beyond(candidates);
  const VectorXd rest = beyond(white(map(std::span(means.left))));
  const double without = rest.squaredNorm();
  const double determinants = 2.0 * MatrixXd(root.matrixL()).diagonal().array().log().sum() +
                              2.0 * model.matrixR().diagonal().head(rank).array().abs().log().sum();
  for (Index j = 0; j < left.cols(); ++j) {
    const double square = left.col(j).squaredNorm();
    if (!(square > least_left * candidates.col(j).squaredNorm())) continue;
    const double cross = left.col(j).dot(rest), explained = cross * cross / square;
    const double criterion = determinants + std::log(square) + without - explained;
    BestSize& one = best[static_cast<std::size_t>(j)];
    if (criterion < one.criterion) one = {added_term(without, explained, freedom, cross / square), criterion};
  }
}

}  // namespace

std::vector<AddedTerm> added_between_segments(const SegmentMeans& means) {
  // of the mean square that the fit leaves: without slow noise, and in steps fine enough for the weights of the means
  static constexpr double sizes[] = {0.0, 1e-3, 1e-2, 0.1, 0.3, 1.0};
  static constexpr double free = 10.0;          // the same for a bias that each power-up has of its own
  static constexpr std::size_t looked_for = 2;  // kernels: more would take too long
  const Index n = at(means.left.size());
  std::vector<BestSize> best(means.candidates.columns);
  if (n < 2) return std::vector<AddedTerm>(best.size());
  MatrixXd known = map(means.known);
  known.diagonal() += map(std::span(means.white));
  const double mean_square = map(std::span(means.left)).squaredNorm() / static_cast<double>(n);
  const double floor = 1e-12 * (known.diagonal().mean() + mean_square);
  known.diagonal().array() += floor;
  if (!(floor > 0.0)) return std::vector<AddedTerm>(best.size());
  std::vector<MatrixXd> tried{known};
  for (std::size_t c = 0; c < means.kernels.size(); ++c) {
    const MatrixXd kernel = map(means.kernels[c]) * (mean_square / map(means.kernels[c]).diagonal().mean());
    std::vector<MatrixXd> more;
    for (const MatrixXd& one : tried)
      if (c < looked_for)
        for (const double size : sizes) more.push_back(one + size * kernel);
      else
        more.push_back(one + free * kernel);
    tried = std::move(more);
  }
  for (const MatrixXd& covariance : tried) try_covariance(means, covariance, best);
  std::vector<AddedTerm> terms;
  for (const BestSize& one : best) terms.push_back(one.term);
  return terms;
}

}  // namespace tumble
