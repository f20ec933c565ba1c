#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/reduce/prior_rows.hpp"
#include "tumble/reduce/with_prior.hpp"

namespace tumble {
namespace {

constexpr std::size_t many_units = 10;

std::string serial_of(const std::string& input) { return input.substr(input.find('/') + 1); }

/// A parameter of the population that the result has with the same meaning.
const Parameter* shown(const Estimate& result, const Estimate& population, std::size_t k) {
  const auto* own = find_parameter(result, population.parameters[k].name);
  if (!own || !prior_rows::is_normal(result, static_cast<std::size_t>(own - result.parameters.data()))) return nullptr;
  return prior_rows::row_of(*own, population.parameters).known ? own : nullptr;
}

/// The row of the table that says least about units far from the mean.
struct Narrowest {
  double ratio = INFINITY;
  std::string name;
};

Narrowest narrowest(const Estimate& result, const Estimate& population) {
  Narrowest out;
  for (std::size_t k = 0; k < population.parameters.size(); ++k) {
    const auto* own = shown(result, population, k);
    if (!own) continue;
    const double sd = standard_uncertainty(result, static_cast<std::size_t>(own - result.parameters.data()));
    const double ratio = unit_to_unit_sd(population, k) / sd;
    if (ratio < out.ratio) out = {ratio, own->name};
  }
  return out;
}

}  // namespace

double unit_to_unit_sd(const Estimate& population, std::size_t k) {
  for (const auto& line : population.budget)
    if (line.source == "unit to unit") return std::sqrt(line.variance(k));
  return 0.0;
}

Findings about_prior(const Estimate& result, const PriorUse& use) {
  using Severity = Finding::Severity;
  Findings findings;
  const auto& population = *use.population;
  const auto units = population.population->units;
  if (!use.with_prior)
    findings.push_back({Severity::warning,
                        "unit_not_of_population",
                        {{"units", units}, {"together", use.belongs}, {"single", use.belongs_by_one}}});
  if (units < many_units) findings.push_back({Severity::warning, "prior_of_few_units", {{"units", units}}});
  for (const auto& input : population.provenance.inputs)
    if (!result.instrument_serial.empty() && serial_of(input.file) == result.instrument_serial)
      findings.push_back({Severity::warning, "prior_holds_unit", {{"serial", result.instrument_serial}}});
  if (const auto least = narrowest(result, population); use.with_prior && std::isfinite(least.ratio))
    findings.push_back({Severity::info,
                        "far_units_held_less_often",
                        {{"parameter", least.name},
                         {"ratio", least.ratio},
                         {"two", 100.0 * conditional_coverage(least.ratio, 2.0)},
                         {"four", 100.0 * conditional_coverage(least.ratio, 4.0)}}});
  return findings;
}

Table prior_table(const Estimate& result, const PriorUse& use) {
  const auto& population = *use.population;
  Table table{
      "prior",
      fmt::format("{} units as prior: spread of the units and sd with prior beside the sd without, distance from the "
                  "mean in sd, and how often an interval with prior holds a unit 0, 2 and 4 spreads from the mean",
                  population.population->units),
      {{"parameter", Unit()},
       {"spread/sd", Unit()},
       {"with/without", Unit()},
       {"from_mean", Unit()},
       {"at_mean", Unit::parse("%")},
       {"at_2", Unit::parse("%")},
       {"at_4", Unit::parse("%")}},
      {}};
  for (std::size_t k = 0; k < population.parameters.size(); ++k) {
    const auto& name = population.parameters[k].name;
    std::vector<Table::Cell> row{name};
    const auto* own = shown(result, population, k);
    if (!own) {
      row.emplace_back(std::string("not shown"));
      for (int i = 0; i < 5; ++i) row.emplace_back(std::string());
      table.rows.push_back(std::move(row));
      continue;
    }
    const double sd = standard_uncertainty(result, static_cast<std::size_t>(own - result.parameters.data()));
    const double ratio = unit_to_unit_sd(population, k) / sd;
    row.emplace_back(ratio);
    const auto* with = use.with_prior ? find_parameter(*use.with_prior, name) : nullptr;
    if (with)
      row.emplace_back(
          standard_uncertainty(*use.with_prior, static_cast<std::size_t>(with - use.with_prior->parameters.data())) /
          sd);
    else
      row.emplace_back(std::string());
    row.emplace_back((own->value - population.parameters[k].value) /
                     std::hypot(sd, standard_uncertainty(population, k)));
    for (const double away : {0.0, 2.0, 4.0}) row.emplace_back(conditional_coverage(ratio, away));
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace tumble
