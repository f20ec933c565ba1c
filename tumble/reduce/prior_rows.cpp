#include "tumble/reduce/prior_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tumble::prior_rows {

bool is_normal(const Estimate& estimate, std::size_t i) {
  const Parameter& parameter = estimate.parameters[i];
  const double variance = estimate.covariance(i, i);
  return std::isnan(parameter.lower) && std::isnan(parameter.upper) && std::isfinite(parameter.value) &&
         std::isfinite(variance) && variance > 0.0;
}

std::string unresolved(const Parameter& parameter, const std::vector<std::string>& names) {
  std::vector<std::string> terms;
  for (const auto& term : parameter.contains)
    if (std::ranges::find(names, term.name) == names.end() && term.weight != 0.0)
      terms.push_back(
          fmt::format("{:.4g} x {}", term.weight * term.unit.factor() / parameter.unit.factor(), term.name));
  std::ranges::sort(terms);
  std::string text;
  for (const auto& term : terms) text += (text.empty() ? "" : " + ") + term;
  return text;
}

Row row_of(const Parameter& parameter, const std::vector<Parameter>& population) {
  Row row{false, std::vector<double>(population.size(), 0.0)};
  std::vector<std::string> pure;
  for (const auto& known : population)
    if (known.contains.empty()) pure.push_back(known.name);
  for (std::size_t k = 0; k < population.size(); ++k) {
    if (!population[k].contains.empty()) continue;
    for (const auto& term : parameter.contains)
      if (term.name == population[k].name) row.weights[k] += term.weight;
  }
  for (std::size_t k = 0; k < population.size(); ++k)
    if (population[k].name == parameter.name && unresolved(parameter, pure) == unresolved(population[k], pure)) {
      row.known = true;
      row.weights[k] += 1.0;
    }
  return row;
}

}  // namespace tumble::prior_rows
