#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/population/components/likelihood.hpp"
#include "tumble/math/square.hpp"

namespace tumble::components {
namespace {

using Sparse = Eigen::SparseMatrix<double>;  // by columns
using Factor = Eigen::SimplicialLLT<Sparse, Eigen::Lower, Eigen::AMDOrdering<int>>;

/// A variance below this part of all counts as zero: its levels would otherwise vanish from the equations.
constexpr double least_part = 1e-10;

/// The entries of the inverse of L L' where L has entries (Takahashi's recursion): those of column j follow from the
/// columns after it.
class PartialInverse {
 public:
  explicit PartialInverse(const Sparse& lower)
      : lower_(lower), values_(static_cast<std::size_t>(lower.nonZeros())), mark_(size(), -1) {
    for (std::size_t j = size(); j-- > 0;) fill_column(j);
  }

  const std::vector<double>& values() const { return values_; }

 private:
  std::size_t size() const { return static_cast<std::size_t>(lower_.cols()); }
  std::size_t begin(std::size_t column) const { return static_cast<std::size_t>(lower_.outerIndexPtr()[column]); }
  std::size_t row(std::size_t place) const { return static_cast<std::size_t>(lower_.innerIndexPtr()[place]); }

  void fill_column(std::size_t j) {
    const std::size_t first = begin(j), last = begin(j + 1);
    const double* l = lower_.valuePtr();
    sums_.assign(last - first, 0.0);
    for (std::size_t e = first + 1; e < last; ++e) mark_[row(e)] = static_cast<int>(e - first);
    for (std::size_t e = first + 1; e < last; ++e) {
      const std::size_t k = row(e);
      for (std::size_t f = begin(k); f < begin(k + 1); ++f) {
        const int other = mark_[row(f)];
        if (other < 0) continue;
        sums_[static_cast<std::size_t>(other)] += l[e] * values_[f];
        if (row(f) != k) sums_[e - first] += l[first + static_cast<std::size_t>(other)] * values_[f];
      }
    }
    double diagonal = 1.0 / l[first];
    for (std::size_t e = first + 1; e < last; ++e) {
      values_[e] = -sums_[e - first] / l[first];
      diagonal -= l[e] * values_[e];
      mark_[row(e)] = -1;
    }
    values_[first] = diagonal / l[first];
  }

  const Sparse& lower_;
  std::vector<double> values_, sums_;
  std::vector<int> mark_;
};

}  // namespace

struct SparseLikelihood::Parts {
  /// An entry of Z: result i has `value` in `column`.
  struct Entry {
    std::size_t column;
    double value;
  };
  /// Two entries of one result and where their product goes in A, and in its factor.
  struct Pair {
    std::size_t result, place;
    double product;
  };

  const Model& model;
  double least;                     ///< [u^2]
  std::vector<std::size_t> offset;  ///< of the first column of each factor; then of shared errors; then of the end
  std::vector<Entry> entries;       ///< [n x width], one of each factor, then those of shared errors
  std::vector<std::size_t> first;   ///< of each result in entries
  std::vector<Pair> pairs;
  Sparse a;                                               ///< lower triangle of I + U' W U
  std::vector<double> base, ones;                         ///< Z' W Z in the places of A, at repeat_; work
  std::vector<std::size_t> column_of, row_of, in_factor;  ///< of each place of A
  double repeat = -1.0;
  std::vector<double> w;
  Factor factor;

  explicit Parts(const Model& of, double scale) : model(of), least(least_part * scale) {
    list_entries();
    lay_out();
    factor.analyzePattern(a);
    factor.factorize(a);
    find_in_factor();
  }

  void list_entries() {
    const std::size_t factors = model.levels.size(), n = model.values.size();
    offset.assign(1, 0);
    for (const auto count : model.counts) offset.push_back(offset.back() + count);
    offset.push_back(offset.back() + model.shared.columns);
    for (std::size_t i = 0; i < n; ++i) {
      first.push_back(entries.size());
      for (std::size_t c = 0; c < factors; ++c) entries.push_back({offset[c] + model.levels[c][i], 1.0});
      for (std::size_t k = 0; k < model.shared.columns; ++k)
        if (model.shared(i, k) != 0.0) entries.push_back({offset[factors] + k, model.shared(i, k)});
    }
    first.push_back(entries.size());
  }

  /// The pattern of A, and of each pair of entries its place there.
  void lay_out() {
    std::vector<Eigen::Triplet<double>> triplets;
    const auto columns = static_cast<int>(offset.back());
    for (int c = 0; c < columns; ++c) triplets.emplace_back(c, c, 1.0);
    for_pairs([&](std::size_t, std::size_t row, std::size_t column, double) {
      if (row != column) triplets.emplace_back(static_cast<int>(row), static_cast<int>(column), 1e-3);
    });
    a.resize(columns, columns);
    a.setFromTriplets(triplets.begin(), triplets.end(), [](double x, double) { return x; });
    a.makeCompressed();
    for (std::size_t c = 0; c < offset.back(); ++c)
      for (int e = a.outerIndexPtr()[c]; e < a.outerIndexPtr()[c + 1]; ++e) {
        column_of.push_back(c);
        row_of.push_back(static_cast<std::size_t>(a.innerIndexPtr()[e]));
      }
    for_pairs([&](std::size_t result, std::size_t row, std::size_t column, double product) {
      const auto from = row_of.begin() + a.outerIndexPtr()[column], to = row_of.begin() + a.outerIndexPtr()[column + 1];
      const auto place = static_cast<std::size_t>(std::lower_bound(from, to, row) - row_of.begin());
      pairs.push_back({result, place, product});
    });
  }

  template <class Each>
  void for_pairs(const Each& each) const {
    for (std::size_t i = 0; i + 1 < first.size(); ++i)
      for (std::size_t e = first[i]; e < first[i + 1]; ++e)
        for (std::size_t f = e; f < first[i + 1]; ++f)  // columns of a result are in order
          each(i, entries[f].column, entries[e].column, entries[e].value * entries[f].value);
  }

  /// Of each place of A, where it is in the factor, whose columns are in another order.
  void find_in_factor() {
    const Sparse& lower = factor.matrixL().nestedExpression();
    const auto& order = factor.permutationP().indices();
    for (std::size_t e = 0; e < row_of.size(); ++e) {
      const auto [column, row] = std::minmax(order[at(column_of[e])], order[at(row_of[e])]);
      const int* rows = lower.innerIndexPtr();
      const int* place =
          std::lower_bound(rows + lower.outerIndexPtr()[column], rows + lower.outerIndexPtr()[column + 1], row);
      in_factor.push_back(static_cast<std::size_t>(place - rows));
    }
  }

  static Eigen::Index at(std::size_t i) { return static_cast<Eigen::Index>(i); }

  /// Sums of w^power times the products of Z, in the places of A.
  std::vector<double> products(bool squared) const {
    std::vector<double> out(row_of.size(), 0.0);
    for (const Pair& pair : pairs)
      out[pair.place] += pair.product * (squared ? square(w[pair.result]) : w[pair.result]);
    return out;
  }

  /// sd [u] of each column: the root of its variance; 1 of shared errors.
  std::vector<double> scales(const std::vector<double>& variances) const {
    std::vector<double> out(offset.back(), 1.0);
    for (std::size_t c = 0; c < model.levels.size(); ++c)
      std::fill(out.begin() + static_cast<std::ptrdiff_t>(offset[c]),
                out.begin() + static_cast<std::ptrdiff_t>(offset[c + 1]), std::sqrt(std::max(variances[c], least)));
    return out;
  }

  void weigh(double variance) {
    if (variance == repeat) return;
    repeat = variance;
    w.resize(model.own.size());
    for (std::size_t i = 0; i < w.size(); ++i) w[i] = 1.0 / std::max(model.own[i] + variance, least);
    base = products(false);
  }

  /// V^-1 x.
  std::vector<double> inverse_times(const std::vector<double>& x, const std::vector<double>& scale) const {
    Eigen::VectorXd sums = Eigen::VectorXd::Zero(at(offset.back()));
    for (std::size_t i = 0; i < x.size(); ++i)
      for (std::size_t e = first[i]; e < first[i + 1]; ++e)
        sums[at(entries[e].column)] += scale[entries[e].column] * entries[e].value * w[i] * x[i];
    const Eigen::VectorXd solved = factor.solve(sums);
    std::vector<double> out(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      double part = x[i];
      for (std::size_t e = first[i]; e < first[i + 1]; ++e)
        part -= scale[entries[e].column] * entries[e].value * solved[at(entries[e].column)];
      out[i] = w[i] * part;
    }
    return out;
  }

  /// Z_c Z_c' x; x itself for "repeat".
  std::vector<double> spread(const std::vector<double>& x, std::size_t c) const {
    if (c == model.levels.size()) return x;
    std::vector<double> sums(model.counts[c]), out(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) sums[model.levels[c][i]] += x[i];
    for (std::size_t i = 0; i < x.size(); ++i) out[i] = sums[model.levels[c][i]];
    return out;
  }

  /// tr(Z_c' V^-1 Z_c) of each factor, then tr(V^-1).
  std::vector<double> traces(const std::vector<double>& scale) const {
    const PartialInverse inverse(factor.matrixL().nestedExpression());
    std::vector<double> out;
    for (std::size_t c = 0; c < model.levels.size(); ++c) {
      double sum = 0.0;
      for (std::size_t column = offset[c]; column < offset[c + 1]; ++column) {
        const auto diagonal = static_cast<std::size_t>(a.outerIndexPtr()[column]);
        sum += (1.0 - inverse.values()[in_factor[diagonal]]) / square(scale[column]);
      }
      out.push_back(sum);
    }
    double sum = std::accumulate(w.begin(), w.end(), 0.0);
    const auto squared = products(true);
    for (std::size_t e = 0; e < squared.size(); ++e) {
      const double part = squared[e] * scale[row_of[e]] * scale[column_of[e]] * inverse.values()[in_factor[e]];
      sum -= row_of[e] == column_of[e] ? part : 2.0 * part;
    }
    out.push_back(sum);
    return out;
  }

  void add_scores(const std::vector<double>& py, const std::vector<double>& scale, AtVariances& out) const {
    const std::size_t components = model.levels.size() + 1;
    const auto trace = traces(scale);
    const double sum = 1.0 / out.mean_variance;
    std::vector<std::vector<double>> spreads, solved;  // Z_c Z_c' P y and P times it
    for (std::size_t c = 0; c < components; ++c) {
      spreads.push_back(spread(py, c));
      auto p = inverse_times(spreads[c], scale);
      const double mean = std::accumulate(p.begin(), p.end(), 0.0) / sum;
      for (std::size_t i = 0; i < p.size(); ++i) p[i] -= mean * out.weights[i];
      solved.push_back(std::move(p));
      const double projected = dot(out.weights, spread(out.weights, c)) / sum;
      out.score.push_back(0.5 * (dot(py, spreads[c]) - (trace[c] - projected)));
    }
    out.information = Matrix(components, components);
    for (std::size_t c = 0; c < components; ++c)
      for (std::size_t d = 0; d < components; ++d) out.information(c, d) = 0.5 * dot(spreads[c], solved[d]);
  }

  AtVariances at_variances(const std::vector<double>& variances) {
    weigh(variances.back());
    const auto scale = scales(variances);
    for (std::size_t e = 0; e < base.size(); ++e)
      a.valuePtr()[e] = base[e] * scale[row_of[e]] * scale[column_of[e]] + (row_of[e] == column_of[e] ? 1.0 : 0.0);
    factor.factorize(a);
    AtVariances out;
    double determinant = 0.0;  // ln |V|
    for (const double weight : w) determinant -= std::log(weight);
    const Sparse& lower = factor.matrixL().nestedExpression();
    for (std::size_t c = 0; c < offset.back(); ++c)
      determinant += 2.0 * std::log(lower.valuePtr()[lower.outerIndexPtr()[c]]);
    out.weights = inverse_times(std::vector<double>(w.size(), 1.0), scale);
    const double sum = std::accumulate(out.weights.begin(), out.weights.end(), 0.0);
    out.mean_variance = 1.0 / sum;
    out.mean = dot(out.weights, model.values) / sum;
    std::vector<double> residual = model.values;
    for (auto& value : residual) value -= out.mean;
    const auto py = inverse_times(residual, scale);
    out.log_likelihood = -0.5 * (determinant + std::log(sum) + dot(residual, py));
    add_scores(py, scale, out);
    return out;
  }
};

SparseLikelihood::SparseLikelihood(const Model& model, double scale) : parts_(std::make_unique<Parts>(model, scale)) {}
SparseLikelihood::~SparseLikelihood() = default;
SparseLikelihood::SparseLikelihood(SparseLikelihood&&) noexcept = default;

AtVariances SparseLikelihood::at(const std::vector<double>& variances) { return parts_->at_variances(variances); }

}  // namespace tumble::components
