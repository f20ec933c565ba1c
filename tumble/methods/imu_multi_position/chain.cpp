#include "tumble/methods/imu_multi_position/chain.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"

namespace tumble::imu_multi_position {
namespace {

/// How many unknowns after k are tied to it, and itself.
std::size_t tied(const Chain& chain, std::size_t k) { return std::min(Chain::width, chain.band.size() - k); }

/// Subtracts the part of unknown k from all equations after it.
void eliminate(std::size_t k, Chain& chain) {
  const auto& band = chain.band[k];
  const auto border = column(chain.border, k);
  for (std::size_t i = 1; i < tied(chain, k); ++i) {
    const double factor = -band[i] / band[0];
    if (factor == 0.0) continue;
    for (std::size_t j = i; j < tied(chain, k); ++j) chain.band[k + i][j - i] += factor * band[j];
    chain.chain_right[k + i] += factor * chain.chain_right[k];
    add_scaled(column(chain.border, k + i), factor, border);
  }
  for (std::size_t j = 0; j < border.size(); ++j)
    add_scaled(column(chain.common, j).subspan(j), -border[j] / band[0], border.subspan(j));
  add_scaled(chain.right, -chain.chain_right[k] / band[0], border);
}

/// The unknowns and their block of the inverse, from the last to the first.
void substitute_back(const Chain& chain, ChainSolution& out) {
  const std::size_t n = chain.band.size();
  out.unknowns = chain.chain_right;
  out.cross = Matrix(out.parameters.size(), n);
  for (std::size_t k = n; k-- > 0;) {
    const auto border = column(chain.border, k);
    const auto cross = column(out.cross, k);
    out.unknowns[k] -= dot(border, out.parameters);
    for (std::size_t j = 0; j < border.size(); ++j) add_scaled(cross, -border[j], column(out.covariance, j));
    for (std::size_t i = 1; i < tied(chain, k); ++i) {
      out.unknowns[k] -= chain.band[k][i] * out.unknowns[k + i];
      add_scaled(cross, -chain.band[k][i], column(out.cross, k + i));
    }
    out.unknowns[k] /= chain.band[k][0];
    for (double& value : cross) value /= chain.band[k][0];
  }
}

}  // namespace

Chain::Chain(std::size_t parameters, std::size_t unknowns)
    : common(parameters, parameters),
      right(parameters),
      border(parameters, unknowns),
      band(unknowns),
      chain_right(unknowns) {}

ChainSolution solve(Chain chain, bool covariances) {
  ChainSolution out;
  for (std::size_t k = 0; k < chain.band.size(); ++k) {
    const double pivot = chain.band[k][0];
    if (!(pivot > 0.0)) return out;
    out.log_determinant += std::log(pivot);
    out.gain += chain.chain_right[k] * chain.chain_right[k] / pivot;
    eliminate(k, chain);
  }
  const Cholesky factor = cholesky(chain.common);
  if (!factor.positive) return out;
  out.log_determinant += factor.log_determinant;
  out.parameters = solve(factor, chain.right);
  out.gain += dot(out.parameters, chain.right);
  out.positive_definite = std::ranges::all_of(out.parameters, [](double v) { return std::isfinite(v); });
  if (!covariances) return out;
  out.covariance = solve(factor, identity(chain.right.size()));
  substitute_back(chain, out);
  return out;
}

}  // namespace tumble::imu_multi_position
