#include "tumble/methods/accelerometer_four_position/stacked.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/math/eigen/view.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer_four_position {
namespace {

using Eigen::Index;

FourResults results_of(const Bench& bench, const Cell& cell, bool two) {
  const auto output = [&](std::size_t position) { return bench.positions[position].output; };
  const double gravity = bench.positions[cell.up].gravity;
  if (two) return from_two({output(cell.up), 0.0, output(cell.down), 0.0}, gravity);
  return from_four({output(cell.up), output(*cell.second), output(cell.down), output(*cell.fourth)}, gravity,
                   cell.o_level ? -1.0 : 1.0);
}

/// The same number up and down, or nothing finite: there is no scale factor.
void refuse_flat(const Bench& bench, const Stacked& all) {
  std::vector<std::string> problems;
  for (std::size_t c = 0; c < all.cells; ++c) {
    bool good = true;
    for (std::size_t b = 0; b < all.active.size(); ++b) good = good && std::isfinite(all.z[all.index(b, c)]);
    if (!good)
      problems.push_back(fmt::format("run {}, {}: positions 1 and 3 show the same output", bench.cells[c].run,
                                     in_words(bench.cells[c].temperature)));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

}  // namespace

Stacked stacked_of(const Bench& bench, bool two) {
  Stacked all;
  all.active =
      two ? std::vector{bias, scale_factor_error} : std::vector{bias, scale_factor_error, second_order, misalignment};
  all.cells = bench.cells.size();
  const Index n = at(all.active.size() * all.cells);
  all.z = Eigen::VectorXd::Zero(n);
  all.slope = Eigen::MatrixXd::Zero(n, at(bench.evidence.test.stretches.size()));
  for (std::size_t c = 0; c < all.cells; ++c) {
    const Cell& cell = bench.cells[c];
    const FourResults results = results_of(bench, cell, two);
    for (std::size_t b = 0; b < all.active.size(); ++b) {
      const Index i = all.index(b, c);
      const auto& slope = results.slope[all.active[b]];
      all.z[i] = results.value[all.active[b]];
      const auto set = [&](std::size_t position, double value) {
        all.slope(i, at(bench.positions[position].stretch)) = value;
      };
      set(cell.up, slope[0]);
      set(cell.down, slope[2]);
      if (two) continue;
      set(*cell.second, slope[1]);
      set(*cell.fourth, slope[3]);
    }
  }
  refuse_flat(bench, all);
  return all;
}

}  // namespace tumble::accelerometer_four_position
