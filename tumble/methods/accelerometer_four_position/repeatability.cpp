#include "tumble/methods/accelerometer_four_position/repeatability.hpp"

#include <set>

#include "tumble/math/eigen/view.hpp"
#include "tumble/methods/accelerometer_four_position/components.hpp"

namespace tumble::accelerometer_four_position {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd means_by_temperature(const Bench& bench) {
  MatrixXd x = MatrixXd::Zero(at(bench.cells.size()), at(bench.group_temperature.size()));
  for (std::size_t c = 0; c < bench.cells.size(); ++c) x(at(c), at(bench.cells[c].group)) = 1.0;
  return x;
}

/// About the columns of x.
Found repeatability_of(const Bench& bench, const Stacked& all, std::size_t block, const MatrixXd& x,
                       const MatrixXd& known) {
  const Index n = at(all.cells), first = all.index(block, 0);
  std::vector<Matrix> kernels{plain(MatrixXd::Identity(n, n))};
  std::vector<std::string> names{repeated(bench) ? "repeatability" : "scatter about the polynomial"};
  std::set<std::size_t> power_ups;
  for (const auto& cell : bench.cells) power_ups.insert(cell.power_up);
  if (power_ups.size() > 1 && power_ups.size() < all.cells && n - x.cols() >= 3) {
    kernels.push_back(plain(same_power_up(bench)));
    names.emplace_back("turn-on repeatability");
  }
  const VectorXd z = all.z.segment(first, n);
  const Components found =
      components_of(plain(x), {z.data(), z.data() + n}, plain(known.block(first, first, n, n)), kernels);
  Found out;
  for (std::size_t k = 0; k < kernels.size(); ++k) {
    MatrixXd kernel = MatrixXd::Zero(all.z.size(), all.z.size());
    kernel.block(first, first, n, n) = map(kernels[k]);
    out.unknown.push_back({names[k], std::move(kernel), found.variance[k]});
  }
  out.covariance = map(found.covariance);
  return out;
}

}  // namespace

MatrixXd same_power_up(const Bench& bench) {
  const Index n = at(bench.cells.size());
  MatrixXd kernel = MatrixXd::Zero(n, n);
  for (Index a = 0; a < n; ++a)
    for (Index b = 0; b < n; ++b)
      kernel(a, b) =
          bench.cells[static_cast<std::size_t>(a)].power_up == bench.cells[static_cast<std::size_t>(b)].power_up;
  return kernel;
}

bool repeated(const Bench& bench) { return bench.cells.size() > bench.group_temperature.size(); }

std::vector<Found> repeatabilities(const Bench& bench, const Stacked& all, const Design& design,
                                   const MatrixXd& known) {
  std::vector<Found> found;
  for (std::size_t b = 0; b < all.active.size(); ++b) {
    const Polynomial& block = design.blocks[b];
    const MatrixXd x = repeated(bench)
                           ? means_by_temperature(bench)
                           : MatrixXd(design.x.block(all.index(b, 0), at(block.first), at(all.cells), at(block.count)));
    found.push_back(repeatability_of(bench, all, b, x, known));
  }
  return found;
}

}  // namespace tumble::accelerometer_four_position
