#include "tumble/report/shape.hpp"

#include <fmt/format.h>

#include "tumble/units/error.hpp"

namespace tumble {

void require_shape(const Estimate& estimate) {
  Problems problems;
  const auto expect = [&](const std::string& what, std::size_t size, std::size_t expected) {
    if (size != expected) problems.push_back(say("{} has {} values, not {}", Name{what}, size, expected));
  };
  const auto count = estimate.parameters.size();
  const auto& covariance = estimate.covariance;
  if (covariance.rows != count || covariance.columns != count || covariance.values.size() != count * count) {
    problems.push_back(say("covariance is {} x {} for {} parameters", covariance.rows, covariance.columns, count));
  }
  for (const auto& part : estimate.budget) {
    expect("budget contribution '" + part.source + "'", part.factor.rows, count);
  }
  for (const auto& table : estimate.tables) {
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      expect(fmt::format("row {} of table '{}'", i, table.name), table.rows[i].size(), table.columns.size());
    }
  }
  for (const auto& curve : estimate.curves) {
    const auto length = curve.x.values.size();
    expect("y of curve '" + curve.name + "'", curve.y.values.size(), length);
    if (!curve.lower.empty()) expect("lower band of curve '" + curve.name + "'", curve.lower.size(), length);
    expect("upper band of curve '" + curve.name + "'", curve.upper.size(), curve.lower.size());
  }
  if (!problems.empty()) throw Error{Error::Kind::internal, std::move(problems)};
}

}  // namespace tumble
