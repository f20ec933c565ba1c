#include "tumble/methods/imu_multi_position/chain.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"

namespace tumble::imu_multi_position {
namespace {

using Links = std::vector<Chain::Link>;

double determinant(const Matrix2& m) { return m[0][0] * m[1][1] - m[0][1] * m[1][0]; }

Matrix2 inverse(const Matrix2& m) {
  const double d = determinant(m);
  return {{{m[1][1] / d, -m[0][1] / d}, {-m[1][0] / d, m[0][0] / d}}};
}

Pair product(const Matrix2& m, const Pair& v) {
  return {m[0][0] * v[0] + m[0][1] * v[1], m[1][0] * v[0] + m[1][1] * v[1]};
}

/// to -= factor_a a + factor_b b, vectors [n].
void subtract(std::span<double> to, double factor_a, std::span<const double> a, double factor_b,
              std::span<const double> b) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] -= factor_a * a[i] + factor_b * b[i];
}

/// Subtracts what the elimination of a pair takes from the parameters: C -= B D^-1 B', right -= B D^-1 c.
/// Given: part = B D^-1 [p x 2].
void eliminate(const Chain::Link& link, const Matrix& part, Chain& chain) {
  const std::size_t p = part.rows;
  for (std::size_t j = 0; j < p; ++j)
    subtract(column(chain.common, j).subspan(j), link.border(j, 0), column(part, 0).subspan(j), link.border(j, 1),
             column(part, 1).subspan(j));
  subtract(chain.right, link.right[0], column(part, 0), link.right[1], column(part, 1));
}

/// Subtracts it from the pair that follows.
void eliminate(const Chain::Link& link, const Matrix2& inverse, const Matrix& part, Chain::Link& next) {
  for (std::size_t i = 0; i < 2; ++i) {
    const Pair column_of_next{link.next[0][i], link.next[1][i]};
    const Pair forward = product(inverse, column_of_next);  // row i of E' D^-1
    for (std::size_t j = 0; j < 2; ++j) next.own[i][j] -= forward[0] * link.next[0][j] + forward[1] * link.next[1][j];
    next.right[i] -= forward[0] * link.right[0] + forward[1] * link.right[1];
    subtract(column(next.border, i), column_of_next[0], column(part, 0), column_of_next[1], column(part, 1));
  }
}

/// The pairs and their blocks of the inverse, from the last pair to the first.
void substitute_back(const Links& links, const std::vector<Matrix2>& inverses, ChainSolution& out) {
  const std::size_t n = links.size(), p = out.parameters.size();
  out.pairs.resize(n), out.cross.resize(n);
  for (std::size_t k = n; k-- > 0;) {
    const Chain::Link& link = links[k];
    Pair right = link.right;
    std::array<std::vector<double>, 2> cross;
    for (std::size_t c = 0; c < 2; ++c) {
      right[c] -= dot(column(link.border, c), out.parameters);
      cross[c] = scaled(-1.0, out.covariance * column(link.border, c));
      if (k + 1 == n) continue;
      right[c] -= link.next[c][0] * out.pairs[k + 1][0] + link.next[c][1] * out.pairs[k + 1][1];
      subtract(cross[c], link.next[c][0], out.cross[k + 1][0], link.next[c][1], out.cross[k + 1][1]);
    }
    out.pairs[k] = product(inverses[k], right);
    for (std::size_t c = 0; c < 2; ++c) {
      out.cross[k][c].assign(p, 0.0);
      subtract(out.cross[k][c], -inverses[k][c][0], cross[0], -inverses[k][c][1], cross[1]);
    }
  }
}

}  // namespace

Chain::Chain(std::size_t parameters, std::size_t pairs)
    : common(parameters, parameters), right(parameters), links(pairs, Link{.border = Matrix(parameters, 2)}) {}

ChainSolution solve(Chain chain, bool covariances) {
  ChainSolution out;
  std::vector<Matrix2> inverses;
  for (std::size_t k = 0; k < chain.links.size(); ++k) {
    const Chain::Link& link = chain.links[k];
    const double size = determinant(link.own);
    if (!(size > 0.0)) return out;
    const Matrix2& inverted = inverses.emplace_back(inverse(link.own));
    Matrix part(chain.right.size(), 2);
    for (std::size_t c = 0; c < 2; ++c)
      subtract(column(part, c), -inverted[0][c], column(link.border, 0), -inverted[1][c], column(link.border, 1));
    const Pair solved = product(inverted, link.right);
    out.log_determinant += std::log(size);
    out.gain += link.right[0] * solved[0] + link.right[1] * solved[1];
    eliminate(link, part, chain);
    if (k + 1 < chain.links.size()) eliminate(link, inverted, part, chain.links[k + 1]);
  }
  const Cholesky factor = cholesky(chain.common);
  if (!factor.positive) return out;
  out.log_determinant += factor.log_determinant;
  out.parameters = solve(factor, chain.right);
  out.gain += dot(out.parameters, chain.right);
  out.positive_definite = std::ranges::all_of(out.parameters, [](double v) { return std::isfinite(v); });
  if (!covariances) return out;
  out.covariance = solve(factor, identity(chain.right.size()));
  substitute_back(chain.links, inverses, out);
  return out;
}

}  // namespace tumble::imu_multi_position
