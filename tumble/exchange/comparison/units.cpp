#include <algorithm>
#include <cmath>

#include "tumble/exchange/comparison.hpp"
#include "tumble/report/names.hpp"
#include "tumble/report/rounding.hpp"

namespace tumble {
namespace {

/// Every parameter of any result, once, in the order of the first that has it.
std::vector<const Parameter*> parameters_of_any(const std::vector<NamedResult>& results) {
  std::vector<const Parameter*> all;
  for (const auto& [name, estimate] : results)
    for (const auto& parameter : estimate.parameters)
      if (std::ranges::none_of(all, [&](const auto* one) { return one->name == parameter.name; }))
        all.push_back(&parameter);
  return all;
}

void add_unit(const Parameter& parameter, const Estimate& estimate, Figure::Series& series) {
  double value = NAN, lower = NAN, upper = NAN;
  const auto* found = find_parameter(estimate, parameter.name);
  if (found && found->unit.dimension() == parameter.unit.dimension() && std::isfinite(found->value)) {
    const auto interval = interval95(estimate, static_cast<std::size_t>(found - estimate.parameters.data()));
    value = parameter.unit.from_si(found->value);
    lower = parameter.unit.from_si(interval.lower);
    upper = parameter.unit.from_si(interval.upper);
  }
  series.x.push_back(static_cast<double>(series.x.size() + 1));
  series.y.push_back(value);
  series.lower.push_back(lower);
  series.upper.push_back(upper);
}

}  // namespace

std::vector<Figure> figures_of_units(const std::vector<NamedResult>& results) {
  std::vector<Figure> figures;
  for (const auto* parameter : parameters_of_any(results)) {
    const auto readable = readable_name(parameter->name);
    Figure figure{
        .name = parameter->name,
        .x = {"number of the result", {}, false},
        .y = {readable, parameter->unit, false},
        .series =
            {{.name = readable, .points = true, .x = {}, .y = {}, .lower = {}, .upper = {}, .band = "95 % interval"}},
        .notes = {}};
    for (const auto& [name, estimate] : results) add_unit(*parameter, estimate, figure.series.front());
    figures.push_back(std::move(figure));
  }
  return figures;
}

}  // namespace tumble
