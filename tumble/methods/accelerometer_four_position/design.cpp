#include "tumble/methods/accelerometer_four_position/design.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/eigen/view.hpp"

namespace tumble::accelerometer_four_position {

using Eigen::Index;
using Eigen::MatrixXd;

Design design_of(const Bench& bench, const Stacked& all, std::size_t order) {
  Design design;
  const double low = bench.group_temperature.front(), high = bench.group_temperature.back();
  design.centre = 0.5 * (low + high);
  design.half = std::max(1.0, 0.5 * (high - low));
  std::size_t columns = 0;
  for (const auto quantity : all.active) {
    const std::size_t count = quantity == bias || quantity == scale_factor_error ? order + 1 : 1;
    design.blocks.push_back({columns, count});
    columns += count;
  }
  design.x = MatrixXd::Zero(all.z.size(), at(columns));
  for (std::size_t b = 0; b < all.active.size(); ++b)
    for (std::size_t k = 0; k < design.blocks[b].count; ++k)
      for (std::size_t c = 0; c < all.cells; ++c)
        design.x(all.index(b, c), at(design.blocks[b].first + k)) =
            std::pow(design.u(bench.cells[c].temperature), static_cast<double>(k));
  return design;
}

MatrixXd to_plain(const Design& design) {
  MatrixXd convert = MatrixXd::Zero(design.x.cols(), design.x.cols());
  for (const auto& block : design.blocks) {
    for (std::size_t k = 0; k < block.count; ++k) {
      double binomial = 1.0;
      for (std::size_t j = 0; j <= k; ++j) {
        convert(at(block.first + j), at(block.first + k)) =
            binomial * std::pow(-celsius(design.centre), static_cast<double>(k - j)) /
            std::pow(design.half, static_cast<double>(k));
        binomial *= static_cast<double>(k - j) / static_cast<double>(j + 1);
      }
    }
  }
  return convert;
}

}  // namespace tumble::accelerometer_four_position
