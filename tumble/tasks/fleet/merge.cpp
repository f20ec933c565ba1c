#include "tumble/tasks/fleet/merge.hpp"

#include "tumble/core/budget.hpp"

namespace tumble::fleet {
namespace {

/// The factor of a line whose parameters stand from row `first` on among `rows`.
Matrix shifted(const Matrix& factor, std::size_t first, std::size_t rows) {
  Matrix wide(rows, factor.columns);
  for (std::size_t i = 0; i < factor.rows; ++i)
    for (std::size_t j = 0; j < factor.columns; ++j) wide(first + i, j) = factor(i, j);
  return wide;
}

}  // namespace

void append(const Estimate& one, const std::string& parameter, Estimate& all) {
  const std::size_t before = all.parameters.size(), rows = before + one.parameters.size();
  for (auto& line : all.budget) line.factor = shifted(line.factor, 0, rows);
  for (const auto& line : one.budget)
    all.budget.push_back({parameter + ": " + line.source, line.key, shifted(line.factor, before, rows)});
  all.parameters.insert(all.parameters.end(), one.parameters.begin(), one.parameters.end());
  all.covariance = covariance_of(all.budget, rows);
  for (auto table : one.tables) {
    table.caption = parameter + ": " + table.caption;
    table.name = parameter + " " + table.name;
    all.tables.push_back(std::move(table));
  }
  for (auto curve : one.curves) {
    curve.figure = parameter + ", " + curve.figure;
    all.curves.push_back(std::move(curve));
  }
}

}  // namespace tumble::fleet
