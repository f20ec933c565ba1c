#include "tumble/methods/dtg_centrifuge/levels.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/dtg_centrifuge/lag.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using Row = std::vector<double>;

Row times(double factor, Row row) {
  for (double& one : row) one *= factor;
  return row;
}

Row plus(Row a, const Row& b) {
  for (std::size_t k = 0; k < a.size(); ++k) a[k] += b[k];
  return a;
}

}  // namespace

Unit sensitivity() { return Unit::parse("deg/h/g"); }

Levels::Levels(const Outcome& outcome, const std::vector<Level>& levels)
    : outcome_(outcome), levels_(levels), rows_(levels_with_lag(outcome.levels, outcome.polynomial)) {}

Function Levels::part(std::size_t level, std::size_t c) const {
  Function out{0.0, Row(size())};
  for (std::size_t k = 0; k < size(); ++k) out.gradient[k] = rows_(level * parts() + c, k);
  out.value = dot(out.gradient, outcome_.levels.value);
  return out;
}

Function Levels::K(std::size_t level) const {
  Function out{0.0, Row(size())};
  double square = 0.0, noise = 0.0;
  for (std::size_t c = 0; c < parts(); ++c) {
    const Function one = part(level, c);
    square += one.value * one.value;
    // a lag turns p + iq and leaves its size
    for (const auto& source : outcome_.levels.fit.sources)
      if (source.source != lag_source) noise += quadratic_form(one.gradient, source.covariance);
  }
  const double size = std::sqrt(square);
  for (std::size_t c = 0; c < parts(); ++c) {
    const Function one = part(level, c);
    out.gradient = plus(out.gradient, times(size > 0.0 ? one.value / size : 1.0, one.gradient));
  }
  const bool subtract_noise = outcome_.corrected && outcome_.take == Take::both_parts;
  out.value = subtract_noise ? std::sqrt(std::max(0.0, square - noise)) : size;
  return out;
}

Function Levels::fitted(const Level& level) const {
  const Polynomial& p = outcome_.polynomial;
  const Row row = p.row(level);
  std::vector<Function> part(parts());
  double square = 0.0;
  for (std::size_t c = 0; c < parts(); ++c) {
    part[c].gradient.assign(size(), 0.0);
    for (std::size_t k = 0; k < row.size(); ++k) {
      const std::size_t at = c * p.each() + k;
      part[c].value += row[k] * p.value[at];
      for (std::size_t n = 0; n < size(); ++n) part[c].gradient[n] += row[k] * p.of_levels(at, n);
    }
    square += part[c].value * part[c].value;
  }
  Function out{std::sqrt(square), Row(size())};
  for (const Function& one : part) out.gradient = plus(out.gradient, times(one.value / out.value, one.gradient));
  return out;
}

std::size_t Levels::first(std::size_t level) const {
  std::size_t first = level;
  while (first > 0 && levels_[first - 1].spin_up == levels_[level].spin_up) --first;
  return first;
}

Function Levels::zeta(std::size_t level) const {
  if (first(level) == level) return {0.0, Row(size())};
  return ratio_less_one(K(level), K(first(level)));
}

Function Levels::zeta_fitted(std::size_t level) const {
  if (first(level) == level && bends()) return {0.0, Row(size())};
  return zeta_fitted(levels_[level], first(level));
}

Function Levels::zeta_fitted(const Level& level, std::size_t first) const {
  if (!bends()) return {std::nan(""), Row(size())};
  return ratio_less_one(fitted(level), fitted(levels_[first]));
}

Function Levels::ratio_less_one(const Function& here, const Function& there) const {
  if (!(there.value > 0.0)) return {std::nan(""), Row(size())};
  return {here.value / there.value - 1.0, plus(times(1.0 / there.value, here.gradient),
                                               times(-here.value / (there.value * there.value), there.gradient))};
}

}  // namespace tumble::dtg_centrifuge
