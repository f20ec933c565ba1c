#include "tumble/tasks/fleet/risk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <map>

#include "tumble/archive/history.hpp"
#include "tumble/core/budget.hpp"
#include "tumble/core/columns.hpp"
#include "tumble/exchange/decision.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/population/capability.hpp"
#include "tumble/math/population/outliers.hpp"
#include "tumble/math/square.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/fleet/merge.hpp"
#include "tumble/units/error.hpp"

namespace tumble::fleet {
namespace {

constexpr double wanted_risk = 0.005;  ///< of all units, accepted and out of tolerance: for the guard band of the fleet
constexpr std::size_t fewest_for_outliers = 5, fewest_on_chart = 10;

/// Each unit once, without the outliers: what the production is.
struct Production {
  std::vector<UnitValue> units;
  double sd = 0.0;  ///< [SI] median standard uncertainty of a result, shared errors included
  Unit shown;
};

Production production_of(const ParameterOverUnits& over) {
  std::map<std::int64_t, ChartValue> first;
  for (const auto& value : over.values)
    if (std::isfinite(value.value) && std::isfinite(value.private_sd)) first.emplace(value.unit, value);
  Production production{.shown = over.shown};
  std::vector<double> sds;
  for (const auto& [unit, value] : first) {
    production.units.push_back({value.value, value.private_sd});
    sds.push_back(value.sd);
  }
  if (!sds.empty()) production.sd = median(sds);
  if (production.units.size() < fewest_for_outliers) return production;
  const auto outliers = outlier_units(production.units);
  std::vector<UnitValue> kept;
  for (std::size_t i = 0; i < production.units.size(); ++i)
    if (!outliers.outlier[i]) kept.push_back(production.units[i]);
  production.units = std::move(kept);
  return production;
}

/// Values of the units in their order over normal scores, and the line of the true values: measurement removed.
std::vector<Curve> distribution(const Production& production, const std::string& name) {
  const boost::math::normal normal;
  auto units = production.units;
  std::ranges::sort(units, {}, &UnitValue::value);
  const auto spread = spread_of_units(units);
  Curve truth{
      .name = "true values", .figure = "distribution", .x = {"normal score", Unit()}, .y = {name, production.shown}};
  Curve values = truth;
  values.name = "units";
  values.points = true;
  const double count = static_cast<double>(units.size());
  for (std::size_t i = 0; i < units.size(); ++i) {
    const double score = quantile(normal, (static_cast<double>(i) + 0.625) / (count + 0.25));
    add_point(values, score, units[i].value);
    add_point(truth, score, spread.mean + spread.sd * score);
  }
  return {values, truth};
}

struct Rule {
  std::string name;
  Tolerance acceptance;
};

std::vector<Rule> rules_of(const Production& production, const std::vector<Population>& populations,
                           const Tolerance& tolerance) {
  const Measured measured{.value = 0.0, .sd = production.sd};
  std::vector<Rule> rules;
  for (const char* const text : {"simple", "guarded", "method6"}) {
    if (std::string_view(text) == "method6" && !(std::isfinite(tolerance.lower) && std::isfinite(tolerance.upper)))
      continue;
    rules.push_back({text, acceptance_of(measured, tolerance, parse_decision_rule(text))});
  }
  rules.push_back({fmt::format("fleet, {:g} %", 100.0 * wanted_risk),
                   acceptance_of_fleet(populations, production.sd, tolerance, wanted_risk)});
  return rules;
}

/// What each decision rule accepts and rejects.
Table risk_table(const Production& production, const std::vector<Population>& populations, const Tolerance& tolerance) {
  struct Row {
    Rule rule;
    GlobalRisk risk;
  };
  std::vector<Row> rows;
  for (const Rule& rule : rules_of(production, populations, tolerance))
    rows.push_back({rule, global_risk(populations, production.sd, tolerance, rule.acceptance)});
  const auto end = [](double Tolerance::*of, const char* of_none) {
    return [of, of_none](const Row& r) {
      return r.rule.acceptance.empty() ? Table::Cell(of_none) : r.rule.acceptance.*of;
    };
  };
  return tabulate("risk",
                  "share of all units that a decision rule accepts out of tolerance (consumer's risk) and rejects "
                  "within it (producer's risk), over what the production may be",
                  rows,
                  {{"rule", [](const Row& r) { return r.rule.name; }},
                   {"from", production.shown, end(&Tolerance::lower, "nothing")},
                   {"to", production.shown, end(&Tolerance::upper, "is accepted")},
                   {"consumer", "%", [](const Row& r) { return r.risk.consumer; }},
                   {"producer", "%", [](const Row& r) { return r.risk.producer; }}});
}

/// Capability's companions: how many units each rule accepts wrongly and rejects wrongly.
Estimate risks(const Production& production, const WantedParameter& wanted) {
  const Tolerance tolerance{wanted.limits.lower, wanted.limits.upper};
  const auto populations = possible_populations(production.units);
  Estimate one;
  one.tables.push_back(risk_table(production, populations, tolerance));
  std::vector<double> consumer, producer;
  for (const auto& population : populations) {
    const auto risk = global_risk(population, production.sd, tolerance, tolerance);
    consumer.push_back(risk.consumer);
    producer.push_back(risk.producer);
  }
  std::vector<double> variances;
  const auto add = [&](const char* end, const char* description, std::vector<double> draws) {
    Parameter parameter;
    parameter.name = wanted.name + end, parameter.symbol = parameter.name;
    parameter.description = description, parameter.unit = Unit::parse("%");
    std::ranges::sort(draws);
    const auto at = [&](double share) {
      return draws[static_cast<std::size_t>(share * static_cast<double>(draws.size() - 1))];
    };
    parameter.lower = at(0.025), parameter.upper = at(0.975);
    double sum = 0.0, squares = 0.0;
    for (const double draw : draws) sum += draw;
    parameter.value = sum / static_cast<double>(draws.size());
    for (const double draw : draws) squares += square(draw - parameter.value);
    variances.push_back(squares / static_cast<double>(draws.size() - 1));
    one.parameters.push_back(parameter);
  };
  add("_consumer_risk", "accepted and out of tolerance, of all units, without a guard band", std::move(consumer));
  add("_producer_risk", "rejected and within tolerance, of all units, without a guard band", std::move(producer));
  one.budget = {independent_errors("what the production may be", variances)};
  one.covariance = covariance_of(one.budget, one.parameters.size());
  return one;
}

std::string mean_of(const Estimate& one, const std::string& name, const Unit& unit) {
  const auto* const mean = find_parameter(one, name);
  if (!mean) return "";
  const auto index = static_cast<std::size_t>(mean - one.parameters.data());
  return with_uncertainty(unit.from_si(mean->value), unit.difference_from_si(standard_uncertainty(one, index)));
}

/// Value and 95 % interval: "0.31 [0, 0.87]".
std::string interval_of(const Estimate& one, const std::string& name, const Unit& unit) {
  const auto* const found = find_parameter(one, name);
  if (!found) return "";
  const auto shown = [&](double si) { return unit.difference_from_si(si); };
  return fmt::format("{:.3g} [{:.2g}, {:.2g}]", shown(found->value), shown(found->lower), shown(found->upper));
}

/// Adds findings that are not there yet.
void notice(const Findings& findings, const std::string& parameter, Overview& overview) {
  if (overview.noticed.empty() || overview.noticed.back().file != parameter)
    overview.noticed.push_back({parameter, {}});
  auto& all = overview.noticed.back().findings;
  for (const auto& finding : findings) {
    const std::string text = to_json(Findings{finding});
    if (std::ranges::none_of(all, [&](const Finding& other) { return to_json(Findings{other}) == text; }))
      all.push_back(finding);
  }
}

}  // namespace

void add_parameter(const PastResults& results, const WantedParameter& wanted, Overview& overview, Estimate& all) {
  const std::string& name = wanted.name;
  const Estimate summary = summary_of_results(results, {{name, wanted.model}, wanted.limits});
  append(summary, name, all);
  notice(summary.findings, name, overview);
  const Production production = production_of(results.over);
  Estimate extra;
  extra.curves = distribution(production, name);
  const bool limited = std::isfinite(wanted.limits.lower) || std::isfinite(wanted.limits.upper);
  if (limited && production.units.size() >= 3) {
    const Estimate risk = risks(production, wanted);
    append(risk, name, all);
  }
  append(extra, name, all);
  if (production.units.size() >= fewest_on_chart) {
    const Estimate chart = chart_of_results(results, {.what = {name, wanted.model}});
    Estimate drawn;
    drawn.curves = chart.curves;
    notice(chart.findings, name, overview);
    for (const auto& table : chart.tables)
      if (table.name == "alarms" && !table.rows.empty()) drawn.tables.push_back(table);
    append(drawn, name, all);
  }
  const auto* const outliers = find_table(summary, "outliers");
  overview.table.rows.push_back({name, mean_of(summary, name + "_mean", production.shown),
                                 interval_of(summary, name + "_unit_sd", production.shown),
                                 fmt::format("{:.2g}", production.shown.difference_from_si(production.sd)),
                                 production.shown.text(), outliers ? static_cast<double>(outliers->rows.size()) : 0.0,
                                 interval_of(summary, name + "_capability", Unit())});
}

void finish(Overview& overview, Estimate& all) {
  overview.table.name = "fleet";
  overview.table.caption =
      "mean of the units, spread of their true values (the measurement's part is removed), and the median standard "
      "uncertainty of a result";
  overview.table.columns = {{"parameter", {}}, {"mean", {}},     {"unit sd [95 %]", {}}, {"measured to", {}},
                            {"unit", {}},      {"outliers", {}}, {"C_pk [95 %]", {}}};
  all.tables.insert(all.tables.begin(), overview.table);
  for (auto& finding : gathered(overview.noticed)) {
    if (finding.where.empty() && overview.noticed.size() == 1) finding.where = overview.noticed.front().file;
    all.findings.push_back(std::move(finding));
  }
}

}  // namespace tumble::fleet
