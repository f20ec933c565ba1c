#include "tumble/methods/accelerometer_four_position/design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/error.hpp"

namespace tumble::accelerometer_four_position {

double celsius(double temperature) { return temperature - 273.15; }

std::vector<double> powers(double temperature, std::size_t count) {
  std::vector<double> out;
  for (std::size_t j = 0; j < count; ++j) out.push_back(std::pow(celsius(temperature), static_cast<double>(j)));
  return out;
}

double at_temperature(const std::vector<double>& parameters, const Polynomial& polynomial, double temperature) {
  double sum = 0.0;
  for (std::size_t j = polynomial.count; j-- > 0;) sum = sum * celsius(temperature) + parameters[polynomial.first + j];
  return sum;
}

namespace {

FourResults results_of(const Bench& bench, const Cell& cell, bool two) {
  const auto output = [&](std::size_t position) { return bench.positions[position].output; };
  const double gravity = bench.positions[cell.up].gravity;
  if (two) return from_two({output(cell.up), 0.0, output(cell.down), 0.0}, gravity);
  return from_four({output(cell.up), output(*cell.second), output(cell.down), output(*cell.fourth)}, gravity,
                   cell.o_level ? -1.0 : 1.0);
}

/// Throws where positions 1 and 3 show one value, or nothing finite: there is no scale factor.
void refuse_flat(const Bench& bench, const Stacked& all) {
  Problems problems;
  for (std::size_t c = 0; c < all.cells; ++c) {
    bool good = true;
    for (std::size_t b = 0; b < all.active.size(); ++b) good = good && std::isfinite(all.z[all.index(b, c)]);
    if (!good)
      problems.push_back(say("run {}, {}: positions 1 and 3 show the same output", bench.cells[c].run,
                             Name{in_words(bench.cells[c].temperature)}));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

}  // namespace

Stacked stacked_of(const Bench& bench, bool two) {
  Stacked all;
  all.active =
      two ? std::vector{bias, scale_factor_error} : std::vector{bias, scale_factor_error, second_order, misalignment};
  all.cells = bench.cells.size();
  all.z.resize(all.active.size() * all.cells);
  all.slope = Matrix(all.z.size(), bench.evidence.test.stretches.size());
  for (std::size_t c = 0; c < all.cells; ++c) {
    const Cell& cell = bench.cells[c];
    const FourResults results = results_of(bench, cell, two);
    for (std::size_t b = 0; b < all.active.size(); ++b) {
      const std::size_t i = all.index(b, c);
      const auto& slope = results.slope[all.active[b]];
      all.z[i] = results.value[all.active[b]];
      const auto set = [&](std::size_t position, double value) {
        all.slope(i, bench.positions[position].stretch) = value;
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
  design.x = Matrix(all.z.size(), columns);
  for (std::size_t b = 0; b < all.active.size(); ++b)
    for (std::size_t k = 0; k < design.blocks[b].count; ++k)
      for (std::size_t c = 0; c < all.cells; ++c)
        design.x(all.index(b, c), design.blocks[b].first + k) =
            std::pow(design.u(bench.cells[c].temperature), static_cast<double>(k));
  return design;
}

Matrix to_plain(const Design& design) {
  Matrix convert(design.x.columns, design.x.columns);
  for (const auto& block : design.blocks) {
    for (std::size_t k = 0; k < block.count; ++k) {
      double binomial = 1.0;
      for (std::size_t j = 0; j <= k; ++j) {
        convert(block.first + j, block.first + k) = binomial *
                                                    std::pow(-celsius(design.centre), static_cast<double>(k - j)) /
                                                    std::pow(design.half, static_cast<double>(k));
        binomial *= static_cast<double>(k - j) / static_cast<double>(j + 1);
      }
    }
  }
  return convert;
}

}  // namespace tumble::accelerometer_four_position
