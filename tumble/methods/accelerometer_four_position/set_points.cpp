#include "tumble/methods/accelerometer_four_position/set_points.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/median.hpp"
#include "tumble/math/square.hpp"

namespace tumble::accelerometer_four_position {
namespace {

constexpr double one_set_point = 1.0;  ///< [K] set points that differ by less are those of a plan without a chamber

constexpr double least_scale = 1e-6;  ///< [1] less is rounding

bool has_set_points(const Bench& bench) {
  const auto [least, most] = std::ranges::minmax(bench.positions, {}, &Position::set_point);
  return most.set_point - least.set_point > one_set_point;
}

}  // namespace

std::vector<double> off_set_points(const Bench& bench) {
  if (!bench.measured_temperature || bench.cells.empty() || !has_set_points(bench)) return {};
  std::vector<double> sums(bench.group_temperature.size(), 0.0), counts(sums.size(), 0.0);
  for (const Cell& cell : bench.cells)
    for (const std::size_t i : {cell.up, cell.down}) {
      sums[cell.group] += bench.positions[i].temperature - bench.positions[i].set_point;
      counts[cell.group] += 1.0;
    }
  for (std::size_t g = 0; g < sums.size(); ++g) sums[g] = sums[g] / std::max(counts[g], 1.0) - bench.self_heating;
  return sums;
}

double offset_beside_set_points(const Bench& bench, double sd) {
  const std::vector<double> off = off_set_points(bench);
  if (off.empty()) return 0.0;
  const double beyond = square(median(off)) - square(sd);
  return beyond > square(sd) ? std::sqrt(beyond) : 0.0;
}

double scale_beside_set_points(const Bench& bench, double sd) {
  const std::vector<double> off = off_set_points(bench);
  const auto n = static_cast<double>(off.size());
  if (n < 2.0) return 0.0;
  double mean = 0.0, mean_off = 0.0, squares = 0.0, products = 0.0, left = 0.0;
  for (std::size_t g = 0; g < off.size(); ++g) {
    mean += bench.group_temperature[g] / n;
    mean_off += off[g] / n;
  }
  for (std::size_t g = 0; g < off.size(); ++g) {
    squares += square(bench.group_temperature[g] - mean);
    products += (bench.group_temperature[g] - mean) * (off[g] - mean_off);
  }
  const double slope = products / squares;
  for (std::size_t g = 0; g < off.size(); ++g)
    left += square(off[g] - mean_off - slope * (bench.group_temperature[g] - mean));
  const double variance = n > 2.0 ? left / (n - 2.0) / squares : 0.0;
  const double beyond = square(slope) - variance - square(sd);
  return beyond > square(least_scale) ? std::sqrt(beyond) : 0.0;
}

}  // namespace tumble::accelerometer_four_position
