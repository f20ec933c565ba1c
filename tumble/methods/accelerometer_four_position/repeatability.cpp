#include "tumble/methods/accelerometer_four_position/repeatability.hpp"

#include <set>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/methods/accelerometer_four_position/components.hpp"

namespace tumble::accelerometer_four_position {
namespace {

/// About the columns of x.
Repeatability repeatability_of(const Bench& bench, const Stacked& all, std::size_t quantity, const Matrix& x,
                               const Matrix& known) {
  const std::size_t n = all.cells, first = all.index(quantity, 0);
  std::vector<Matrix> kernels{identity(n)};
  std::vector<std::string> names{repeated(bench) ? "repeatability" : "scatter about the polynomial"};
  std::set<std::size_t> power_ups;
  for (const auto& cell : bench.cells) power_ups.insert(cell.power_up);
  if (power_ups.size() > 1 && power_ups.size() < n && n >= x.columns + 3) {
    kernels.push_back(same_power_up(bench));
    names.emplace_back("turn-on repeatability");
  }
  const auto z = all.z.begin() + static_cast<std::ptrdiff_t>(first);
  const Components components =
      components_of(x, {z, z + static_cast<std::ptrdiff_t>(n)}, block(known, first, n, first, n), kernels);
  Repeatability out;
  for (std::size_t k = 0; k < kernels.size(); ++k) {
    Matrix kernel(all.z.size(), all.z.size());
    set_block(kernel, first, first, kernels[k]);
    out.unknown.push_back({names[k], std::move(kernel), components.variance[k]});
  }
  out.covariance = components.covariance;
  return out;
}

}  // namespace

Matrix means_by_temperature(const Bench& bench) {
  Matrix x(bench.cells.size(), bench.group_temperature.size());
  for (std::size_t c = 0; c < bench.cells.size(); ++c) x(c, bench.cells[c].group) = 1.0;
  return x;
}

Matrix same_power_up(const Bench& bench) {
  const std::size_t n = bench.cells.size();
  Matrix kernel(n, n);
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) kernel(a, b) = bench.cells[a].power_up == bench.cells[b].power_up;
  return kernel;
}

bool repeated(const Bench& bench) { return bench.cells.size() > bench.group_temperature.size(); }

std::vector<Repeatability> repeatabilities(const Bench& bench, const Stacked& all, const Design& design,
                                           const Matrix& known) {
  std::vector<Repeatability> out;
  for (std::size_t q = 0; q < all.active.size(); ++q) {
    const Polynomial& p = design.blocks[q];
    const Matrix x =
        repeated(bench) ? means_by_temperature(bench) : block(design.x, all.index(q, 0), all.cells, p.first, p.count);
    out.push_back(repeatability_of(bench, all, q, x, known));
  }
  return out;
}

std::vector<Misfit> misfits(const Bench& bench, const Stacked& all, const Design& design, const Matrix& covariance) {
  constexpr double rare = 1e-4;
  std::vector<Misfit> out;
  const std::size_t n = all.cells, temperatures = bench.group_temperature.size();
  if (n <= temperatures) return out;
  const Matrix means = means_by_temperature(bench);
  for (std::size_t q = 0; q < all.active.size(); ++q) {
    const Polynomial& p = design.blocks[q];
    const std::size_t first = all.index(q, 0);
    const auto z = all.z.begin() + static_cast<std::ptrdiff_t>(first);
    const std::vector<double> values{z, z + static_cast<std::ptrdiff_t>(n)};
    const Matrix x = block(design.x, first, n, p.first, p.count), v = block(covariance, first, n, first, n);
    const auto fit = lack_of_fit(x, means, values, v, static_cast<double>(n - temperatures));
    if (!(fit.freedom > 0.0)) continue;
    const Matrix kernel = means * transposed(means);
    const Components components = components_of(x, values, v, {kernel});
    Misfit misfit{q, fit.probability <= rare, fit.ratio, {}};
    Matrix whole(all.z.size(), all.z.size());
    set_block(whole, first, first, kernel);
    misfit.found.unknown.push_back({"lack of fit of the polynomial", std::move(whole), components.variance[0]});
    misfit.found.covariance = components.covariance;
    out.push_back(std::move(misfit));
  }
  return out;
}

}  // namespace tumble::accelerometer_four_position
