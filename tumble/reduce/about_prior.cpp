#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/reduce/prior_rows.hpp"
#include "tumble/reduce/rig_keys.hpp"
#include "tumble/reduce/with_prior.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace {

constexpr std::size_t many_units = 10;

std::string serial_of(const std::string& input) {
  const auto unit = key_and_value(input, '/');
  return unit ? unit->second : input;
}

/// A parameter of the population, or a sum of several, as a result shows it.
struct ShownRow {
  bool shown = false;
  std::string name;
  double sd = 0.0;      ///< [SI] of the result
  double spread = 0.0;  ///< [SI] of the units
  double away = 0.0;    ///< [1] distance from the mean in standard deviations of the difference
  double with = 0.0;    ///< [SI] sd with prior of the same sum; NaN: there is none
};

/// Standard deviation [SI] of a sum of the population's parameters, of which `covariance` is known.
double sd_of_sum(const std::vector<double>& weights, const Matrix& covariance) {
  return std::sqrt(quadratic_form(weights, covariance));
}

/// Covariance of the population's parameters with prior, in their order.
Matrix covariance_with(const Estimate& with_prior, const Estimate& population) {
  std::vector<std::size_t> which;
  for (const auto& parameter : population.parameters)
    which.push_back(static_cast<std::size_t>(
        std::ranges::find(with_prior.parameters, parameter.name, &Parameter::name) - with_prior.parameters.begin()));
  return chosen_columns(chosen_rows(with_prior.covariance, which), which);
}

Matrix spread_of(const Estimate& population) {
  for (const auto& line : population.budget)
    if (line.source == "unit to unit") return line.factor * transposed(line.factor);
  return {population.parameters.size(), population.parameters.size()};
}

ShownRow shown_row(const Estimate& result, const PriorUse& use, std::size_t k) {
  const auto& population = *use.population;
  ShownRow out{false, population.parameters[k].name};
  const auto* own = find_parameter(result, out.name);
  if (!own) return out;
  const auto i = static_cast<std::size_t>(own - result.parameters.data());
  const auto row = prior_rows::row_of(*own, population.parameters);
  if (!row.known || !prior_rows::is_normal(result, i)) return out;
  out.shown = true;
  out.sd = standard_uncertainty(result, i);
  out.spread = sd_of_sum(row.weights, spread_of(population));
  double mean = 0.0;
  for (std::size_t j = 0; j < row.weights.size(); ++j) mean += row.weights[j] * population.parameters[j].value;
  out.away = (own->value - mean) / std::hypot(out.sd, sd_of_sum(row.weights, population.covariance));
  out.with = use.with_prior ? sd_of_sum(row.weights, covariance_with(*use.with_prior, population)) : NAN;
  return out;
}

/// The row of the table that says least about units far from the mean.
ShownRow narrowest(const Estimate& result, const PriorUse& use) {
  ShownRow out;
  for (std::size_t k = 0; k < use.population->parameters.size(); ++k) {
    const auto row = shown_row(result, use, k);
    if (row.shown && (!out.shown || row.spread / row.sd < out.spread / out.sd)) out = row;
  }
  return out;
}

/// Three digits: these are for people.
double rounded_to_three(double value) { return rounded_to_digits(value, 3); }

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
  for (auto& finding : rig_keys::about_keys({&result, &population})) findings.push_back(std::move(finding));
  for (const auto& input : population.provenance.inputs)
    if (!result.instrument_serial.empty() && serial_of(input.file) == result.instrument_serial)
      findings.push_back({Severity::warning, "prior_holds_unit", {{"serial", result.instrument_serial}}});
  if (const auto least = narrowest(result, use); use.with_prior && least.shown)
    findings.push_back({Severity::info,
                        "far_units_held_less_often",
                        {{"parameter", least.name},
                         {"ratio", least.spread / least.sd},
                         {"two", 100.0 * conditional_coverage(least.spread / least.sd, 2.0)},
                         {"four", 100.0 * conditional_coverage(least.spread / least.sd, 4.0)}}});
  return findings;
}

Table prior_table(const Estimate& result, const PriorUse& use) {
  const auto& population = *use.population;
  std::vector<ShownRow> rows;
  for (std::size_t k = 0; k < population.parameters.size(); ++k) rows.push_back(shown_row(result, use, k));
  const auto number = [](auto of) {
    return [of](const ShownRow& r) { return r.shown ? Table::Cell(rounded_to_three(of(r))) : ""; };
  };
  const auto coverage = [&](double away) {
    return number([away](const ShownRow& r) { return conditional_coverage(r.spread / r.sd, away); });
  };
  const auto ratio = [](const ShownRow& r) {
    return r.shown ? Table::Cell(rounded_to_three(r.spread / r.sd)) : "not shown";
  };
  return tabulate(
      "prior",
      fmt::format("{} units as prior: spread of the units and sd with prior beside the sd without, distance from the "
                  "mean in sd, and how often an interval with prior holds a unit 0, 2 and 4 spreads from the mean",
                  population.population->units),
      rows,
      {{"parameter", &ShownRow::name},
       {"spread/sd", ratio},
       {"with/without", number([](const ShownRow& r) { return r.with / r.sd; })},
       {"from_mean", number([](const ShownRow& r) { return r.away; })},
       {"at_mean", "%", coverage(0.0)},
       {"at_2", "%", coverage(2.0)},
       {"at_4", "%", coverage(4.0)}});
}

}  // namespace tumble
