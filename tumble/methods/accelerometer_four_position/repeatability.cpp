#include "tumble/methods/accelerometer_four_position/repeatability.hpp"

#include <cmath>
#include <set>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/methods/accelerometer_four_position/components.hpp"

namespace tumble::accelerometer_four_position {
namespace {

/// What makes the cells scatter [cells x cells] for a unit of its variance.
struct Cause {
  std::string name;
  Matrix kernel;
};

constexpr const char* lack = "lack of fit of the polynomial";

std::vector<Cause> causes_of(const Bench& bench, std::size_t coefficients) {
  const std::size_t n = bench.cells.size(), temperatures = bench.group_temperature.size();
  std::vector<Cause> causes{{repeated(bench) ? "repeatability" : "scatter about the polynomial", identity(n)}};
  std::set<std::size_t> power_ups;
  for (const auto& cell : bench.cells) power_ups.insert(cell.power_up);
  if (power_ups.size() > 1 && power_ups.size() < n && n >= (repeated(bench) ? temperatures : coefficients) + 3)
    causes.push_back({"turn-on repeatability", same_power_up(bench)});
  if (repeated(bench) && temperatures > coefficients) {
    const Matrix means = means_by_temperature(bench);
    causes.push_back({lack, means * transposed(means)});
  }
  return causes;
}

/// Given: X [cells x coefficients], values and known covariance of one quantity.
Repeatability repeatability_of(const Bench& bench, const Stacked& all, std::size_t quantity, const Matrix& x,
                               Matrix covariance) {
  const std::size_t n = all.cells, first = all.index(quantity, 0);
  const auto z = all.z.begin() + static_cast<std::ptrdiff_t>(first);
  const std::vector<double> values{z, z + static_cast<std::ptrdiff_t>(n)};
  const auto causes = causes_of(bench, x.columns);
  std::vector<Matrix> kernels;
  for (const auto& cause : causes) kernels.push_back(cause.kernel);
  const Components components = components_of(x, values, covariance, kernels);
  Repeatability out;
  out.covariance = components.covariance;
  out.freedom = components.freedom;
  for (std::size_t k = 0; k < kernels.size(); ++k) {
    if (causes[k].name == lack) {
      const auto fit = lack_of_fit(x, means_by_temperature(bench), values, covariance,
                                   static_cast<double>(n - bench.group_temperature.size()));
      out.misfit = std::sqrt(components.variance[k]);
      out.misfit_ratio = fit.ratio;
      out.misfit_chance = fit.probability;
    }
    covariance += components.variance[k] * kernels[k];
    Matrix kernel(all.z.size(), all.z.size());
    set_block(kernel, first, first, kernels[k]);
    out.unknown.push_back({causes[k].name, std::move(kernel), components.variance[k]});
  }
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
    const std::size_t first = all.index(q, 0), n = all.cells;
    const Polynomial& p = design.blocks[q];
    out.push_back(
        repeatability_of(bench, all, q, block(design.x, first, n, p.first, p.count), block(known, first, n, first, n)));
  }
  return out;
}

}  // namespace tumble::accelerometer_four_position
