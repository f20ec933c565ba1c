#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "tumble/archive/statistics/answer.hpp"
#include "tumble/archive/statistics/occasions.hpp"
#include "tumble/archive/statistics/unstated_rigs.hpp"
#include "tumble/core/columns.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/population/capability.hpp"
#include "tumble/math/population/components.hpp"
#include "tumble/math/population/outliers.hpp"
#include "tumble/math/square.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace {

using namespace statistics;
using Severity = Finding::Severity;

constexpr std::size_t fewest_units = 3, fewest_for_outliers = 5, fewest_for_batches = 6;

/// The results of the units of a model.
struct ModelPast {
  PastResults results;
  std::vector<Occasion> occasions;
  SharedBySource errors;
  std::size_t units = 0;
};

bool is_used(const ChartValue& value) { return std::isfinite(value.value) && std::isfinite(value.private_sd); }

ModelPast past_of_model(PastResults results, const ArchivedSelection& what, Findings& findings) {
  ModelPast past{.results = std::move(results), .occasions = {}, .errors = {}};
  begin_at_adjustment(past.results);
  note_same_recordings(past.results, findings);
  std::size_t unused = 0;
  past.occasions = occasions_of(past.results.over, &unused);
  if (unused > 0) findings.push_back({Severity::info, "archived_values_not_used", {{"values", unused}}});
  past.units = first_of_each_unit(past.occasions, past.results.over.units.size()).size();
  if (past.units < fewest_units)
    throw Error(Error::Kind::bad_data, say("a summary of {} needs {} units or more, and the archive has {}",
                                           Name{what.parameter}, fewest_units, past.units));
  past.errors = shared_errors(past.results, past.occasions);
  if (share_unstated_rigs(past.results, past.occasions, past.errors))
    findings.push_back({Severity::info, "rig_of_summary_not_stated", {}});
  return past;
}

/// Factors [n x k] [SI] of the errors that results share, for each value that is used.
Matrix shared_of_values(const ModelPast& past, std::size_t count) {
  std::map<std::int64_t, std::size_t> row;
  std::vector<Occasion> sets;
  for (const auto& [sources, errors] : past.errors) {
    row.emplace(sources, sets.size());
    sets.push_back({.sources = sources});
  }
  const Matrix factors = shared_factors(sets, past.errors);
  Matrix out(count, factors.columns);
  std::size_t i = 0;
  for (const auto& value : past.results.over.values) {
    if (!is_used(value)) continue;
    if (const auto found = row.find(value.sources); found != row.end())
      for (std::size_t k = 0; k < out.columns; ++k) out(i, k) = factors(found->second, k);
    ++i;
  }
  return out;
}

/// [SI] Root mean square over the errors of what they do to the mean of all units.
double shared_sd_of_mean(const ModelPast& past) {
  const Matrix factors = shared_factors(past.occasions, past.errors);
  double variance = 0.0;
  for (std::size_t k = 0; k < factors.columns; ++k) {
    double mean = 0.0;
    for (std::size_t i = 0; i < factors.rows; ++i) mean += factors(i, k) / static_cast<double>(factors.rows);
    variance += square(mean);
  }
  return std::sqrt(variance);
}

/// Results by unit, by day of the unit, and by rig: results that share their errors were made on one rig.
ManyResults many_results(const ModelPast& past, bool days, bool rigs) {
  ManyResults results;
  std::map<std::int64_t, std::size_t> unit_number, rig_number;
  std::map<std::pair<std::size_t, std::int64_t>, std::size_t> day_number;
  ResultFactor unit{"unit", {}}, day{"day", {}}, rig{"rig", {}};
  for (std::size_t i = 0; i < past.results.over.units.size(); ++i) unit_number[past.results.over.units[i].first] = i;
  constexpr double seconds = 86400.0;
  for (const auto& value : past.results.over.values) {
    if (!is_used(value)) continue;
    const auto known = unit_number.find(value.unit);
    results.values.push_back(value.value);
    results.sds.push_back(value.private_sd);
    unit.level.push_back(known->second);
    const std::pair of_day{known->second, static_cast<std::int64_t>(std::floor(value.moment / seconds))};
    day.level.push_back(day_number.emplace(of_day, day_number.size()).first->second);
    rig.level.push_back(rig_number.emplace(value.sources, rig_number.size()).first->second);
  }
  results.shared = shared_of_values(past, results.values.size());
  results.factors = {unit};
  if (days) results.factors.push_back(day);
  if (rigs) results.factors.push_back(rig);
  return results;
}

/// The components that can be separated; what cannot is a finding.
std::optional<SpreadComponents> components_of(const ModelPast& past, Findings& findings) {
  const bool rigs = past.errors.size() > 1;
  for (const auto& [days, with_rigs] : {std::pair{true, rigs}, {false, rigs}, {true, false}, {false, false}}) {
    if (with_rigs != rigs && !rigs) continue;
    try {
      return components_of_spread(many_results(past, days, with_rigs));
    } catch (const Error& error) {
      if (error.kind != Error::Kind::bad_data) throw;
      findings.push_back({Severity::info,
                          "components_not_separated",
                          {{"factors", fmt::format("unit{}{}", days ? ", day" : "", with_rigs ? ", rig" : "")},
                           {"reason", error.problems.front()}}});
    }
  }
  return std::nullopt;
}

/// Each unit once: the mean of its days, with their spread where it is known.
struct UnitMeans {
  std::vector<UnitValue> values;
  std::vector<std::size_t> unit;  ///< index in ParameterOverUnits::units
  std::vector<double> moment;     ///< [s] since 1970, of the first day
};

UnitMeans unit_means(const ModelPast& past, double day_sd) {
  struct Sum {
    double weight = 0.0, value = 0.0, moment = 0.0, plain = 0.0, count = 0.0;
  };
  std::vector<Sum> sums(past.results.over.units.size());
  for (const auto& occasion : past.occasions) {
    auto& sum = sums[occasion.unit];
    const double variance = square(occasion.private_sd) + square(day_sd);
    if (sum.count == 0.0) sum.moment = occasion.moment;
    const double weight = variance > 0.0 ? 1.0 / variance : 0.0;
    sum.weight += weight, sum.value += weight * occasion.value;
    sum.plain += occasion.value, sum.count += 1.0;
  }
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < sums.size(); ++i)
    if (sums[i].count > 0.0) order.push_back(i);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return sums[i].moment; });
  UnitMeans means;
  for (const std::size_t i : order) {
    const auto& sum = sums[i];
    const bool weighted = sum.weight > 0.0;
    means.values.push_back(
        {weighted ? sum.value / sum.weight : sum.plain / sum.count, weighted ? 1.0 / std::sqrt(sum.weight) : 0.0});
    means.unit.push_back(i);
    means.moment.push_back(sum.moment);
  }
  return means;
}

Table components_table(const SpreadComponents& found, const Unit& unit) {
  return tabulate("components",
                  "why results differ: standard deviations with their 95 % intervals; one that may be zero "
                  "begins at 0",
                  found.components,
                  {{"source", &ComponentOfSpread::name},
                   {"sd", unit, &ComponentOfSpread::sd},
                   {"lower", unit, &ComponentOfSpread::lower},
                   {"upper", unit, &ComponentOfSpread::upper},
                   {"degrees of freedom", &ComponentOfSpread::degrees_of_freedom}});
}

Table outliers_table(const OutlierUnits& found, const UnitMeans& means, const ModelPast& past) {
  const auto& over = past.results.over;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < means.values.size(); ++i)
    if (found.outlier[i]) places.push_back(i);
  return tabulate("outliers", "units that do not belong to the population of the others; they are listed, not deleted",
                  places,
                  {{"unit", [&](std::size_t i) { return name_of(over.units[means.unit[i]].second); }},
                   {"value", over.shown, [&](std::size_t i) { return means.values[i].value; }},
                   {"sd", over.shown, [&](std::size_t i) { return means.values[i].sd; }},
                   {"z", [&](std::size_t i) { return found.z[i]; }},
                   {"p", [&](std::size_t i) { return found.p[i]; }}});
}

Table batches_table(const BatchChange& change, const UnitMeans& means, const Unit& unit) {
  const auto date = [&](const BatchChange& c) {
    return day_of(means.moment[std::min(c.after, means.moment.size() - 1)]);
  };
  return tabulate("batches", "the most probable change of the mean in order of production", std::vector{change},
                  {{"after units", &BatchChange::after},
                   {"earliest", &BatchChange::earliest},
                   {"latest", &BatchChange::latest},
                   {"date", date},
                   {"step", unit, &BatchChange::step},
                   {"sd", unit, &BatchChange::step_sd},
                   {"p", &BatchChange::p}});
}

std::vector<Stated> component_numbers(const std::string& name, const Unit& unit, const SpreadComponents& found) {
  std::vector<Stated> numbers{
      {name + "_mean", "mean of the units", unit, found.mean, found.mean_sd, found.mean_lower, found.mean_upper}};
  for (const auto& one : found.components)
    numbers.push_back({name + "_" + one.name + "_sd", "standard deviation, " + one.name, unit, one.sd, std::nan(""),
                       one.lower, one.upper});
  return numbers;
}

/// Units over time; those that the table of outliers names are a series of their own.
std::vector<Curve> units_curves(const ModelPast& past, const UnitMeans& means, const std::vector<Table>& tables,
                                std::vector<Link>& links) {
  const auto& over = past.results.over;
  const auto table = std::ranges::find(tables, "outliers", &Table::name);
  std::set<std::string> outliers;
  if (table != tables.end())
    for (const auto& row : table->rows) outliers.insert(std::get<std::string>(row.front()));
  const std::int64_t day = past.occasions.front().day;
  Curve units = curve_over_time("unit", "units", day, over.parameter, over.shown);
  Curve marked = curve_over_time("outlier", "units", day, over.parameter, over.shown);
  units.points = marked.points = true;
  for (std::size_t i = 0; i < means.values.size(); ++i) {
    const std::string name = name_of(over.units[means.unit[i]].second);
    Curve& curve = outliers.contains(name) ? marked : units;
    add_point(curve, since(day, means.moment[i]), means.values[i].value);
    links.push_back(link_of(curve, name, 0));
  }
  return marked.y.values.empty() ? std::vector{units} : std::vector{units, marked};
}

/// Factors [n x k] [SI] of the shared errors in the mean of each unit.
Matrix shared_of_units(const ModelPast& past, const UnitMeans& means) {
  const Matrix factors = shared_factors(past.occasions, past.errors);
  std::vector<std::size_t> row(past.results.over.units.size());
  for (std::size_t i = 0; i < means.unit.size(); ++i) row[means.unit[i]] = i;
  std::vector<double> days(means.unit.size());
  for (const auto& occasion : past.occasions) days[row[occasion.unit]] += 1.0;
  Matrix out(means.unit.size(), factors.columns);
  for (std::size_t i = 0; i < factors.rows; ++i)
    for (std::size_t k = 0; k < factors.columns; ++k) {
      const std::size_t unit = row[past.occasions[i].unit];
      out(unit, k) += factors(i, k) / days[unit];
    }
  return out;
}

/// [SI^2] Variance of the difference between the units before and after a change, of the errors that they share.
double shared_variance_of_step(const ModelPast& past, const UnitMeans& means, std::size_t after) {
  const Matrix factors = shared_of_units(past, means);
  const auto before = static_cast<double>(after), later = static_cast<double>(factors.rows - after);
  double variance = 0.0;
  for (std::size_t k = 0; k < factors.columns; ++k) {
    double step = 0.0;
    for (std::size_t i = 0; i < factors.rows; ++i) step += factors(i, k) * (i < after ? -1.0 / before : 1.0 / later);
    variance += square(step);
  }
  return variance;
}

/// A change of the mean that neither chance nor the errors that the units share explain, such as another rig.
bool is_significant(const BatchChange& change, double shared_variance) {
  constexpr double significant = 0.01, normal_99 = 2.5758293035489;  // two-sided
  return change.p < significant &&
         std::abs(change.step) > normal_99 * std::hypot(change.step_sd, std::sqrt(shared_variance));
}

/// The units without what is most probable of the errors that they share in different ways, such as two rigs: mu and
/// these errors z, of variance 1, by least squares over units of this spread.
std::vector<UnitValue> without_shared(const ModelPast& past, const UnitMeans& means, double spread) {
  std::vector<UnitValue> values = means.values;
  if (past.errors.size() < 2) return values;
  const Matrix factors = shared_of_units(past, means);
  const std::size_t n = factors.columns;
  double weights = 0.0, sum = 0.0;
  std::vector<double> of_mean(n), right(n);
  Matrix normal(n, n);
  for (std::size_t k = 0; k < n; ++k) normal(k, k) = 1.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double weight = 1.0 / std::max(square(spread) + square(values[i].sd), 1e-300);
    weights += weight, sum += weight * values[i].value;
    for (std::size_t k = 0; k < n; ++k) {
      of_mean[k] += weight * factors(i, k), right[k] += weight * factors(i, k) * values[i].value;
      for (std::size_t l = 0; l < n; ++l) normal(k, l) += weight * factors(i, k) * factors(i, l);
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    right[k] -= of_mean[k] * sum / weights;
    for (std::size_t l = 0; l < n; ++l) normal(k, l) -= of_mean[k] * of_mean[l] / weights;
  }
  const auto errors = solve_symmetric(normal, right);
  for (std::size_t i = 0; i < values.size(); ++i)
    for (std::size_t k = 0; k < n; ++k) values[i].value -= factors(i, k) * errors[k];
  return values;
}

/// Of the units that belong together, where there are enough to say which.
void add_population(const ModelPast& past, const UnitMeans& means, const SummaryRequest& request,
                    std::vector<Stated>& numbers, Estimate& estimate) {
  const auto spread = std::ranges::find(numbers, past.results.over.parameter + "_unit_sd", &Stated::name);
  const auto values = without_shared(past, means, spread != numbers.end() ? spread->value : 0.0);
  std::vector<UnitValue> kept = values;
  if (means.values.size() >= fewest_for_outliers) {
    const auto outliers = outlier_units(values);
    const Table table = outliers_table(outliers, means, past);
    if (!table.rows.empty()) {
      estimate.tables.push_back(table);
      estimate.findings.push_back({Severity::warning, "outlier_units", {{"units", table.rows.size()}}});
      kept.clear();
      for (std::size_t i = 0; i < means.values.size(); ++i)
        if (!outliers.outlier[i]) kept.push_back(values[i]);
    }
    if (means.values.size() >= fewest_for_batches) {
      auto change = batch_change(means.values, square(outliers.kept.sd));
      const double shared = shared_variance_of_step(past, means, change.after);
      if (is_significant(change, shared)) {
        change.step_sd = std::hypot(change.step_sd, std::sqrt(shared));
        estimate.tables.push_back(batches_table(change, means, past.results.over.shown));
        estimate.findings.push_back({Severity::warning, "batch_changed", {{"units", change.after}}});
      }
    }
  }
  const auto& limits = request.limits;
  if (!std::isfinite(limits.lower) && !std::isfinite(limits.upper)) return;
  const auto able = capability_of(kept, {limits.lower, limits.upper}, shared_sd_of_mean(past));
  const std::string& name = past.results.over.parameter;
  numbers.push_back(
      {name + "_capability", "C_pk of the true values", Unit(), able.index, std::nan(""), able.lower, able.upper});
  numbers.push_back(
      {name + "_capability_measured", "C_pk as measured", Unit(), able.measured, 0.0, std::nan(""), std::nan("")});
}

/// Mean and spread of the units where nothing else can be separated: each unit once. What rigs do is no spread of
/// units.
std::vector<Stated> unit_numbers(const ModelPast& past, const UnitMeans& means) {
  constexpr std::size_t fewest_for_rigs = 4;
  const std::string& name = past.results.over.parameter;
  const Unit& unit = past.results.over.shown;
  if (past.errors.size() > 1 && means.values.size() >= fewest_for_rigs) {
    ManyResults results;
    for (const auto& one : means.values) results.values.push_back(one.value), results.sds.push_back(one.sd);
    results.shared = shared_of_units(past, means);
    auto found = components_of_spread(results);
    found.components.front().name = "unit";
    return component_numbers(name, unit, found);
  }
  const auto spread = spread_of_units(means.values);
  const double shared = shared_sd_of_mean(past), k = (spread.mean_upper - spread.mean_lower) / (2.0 * spread.mean_sd);
  const double sd = std::hypot(spread.mean_sd, shared);
  return {
      {name + "_mean", "mean of the units", unit, spread.mean, sd, spread.mean - k * sd, spread.mean + k * sd},
      {name + "_unit_sd", "standard deviation, unit", unit, spread.sd, std::nan(""), spread.sd_lower, spread.sd_upper}};
}

}  // namespace

Estimate summary_of_model(const Archive& archive, const SummaryRequest& request) {
  return summary_of_results(past_results(archive, request.what.parameter, request.what.model), request);
}

Estimate summary_of_results(PastResults results, const SummaryRequest& request) {
  const auto& what = request.what;
  Estimate estimate = answer_of("archive_summary",
                                fmt::format("{} of the units of {}", what.parameter,
                                            what.model.empty() ? "all models" : "the model " + what.model),
                                what);
  const ModelPast past = past_of_model(std::move(results), what, estimate.findings);
  std::vector<Stated> numbers;
  double day_sd = 0.0;
  if (const auto found = components_of(past, estimate.findings)) {
    numbers = component_numbers(what.parameter, past.results.over.shown, *found);
    estimate.tables.push_back(components_table(*found, past.results.over.shown));
    for (const auto& one : found->components)
      if (one.name == "day") day_sd = one.sd;
  }
  const UnitMeans means = unit_means(past, day_sd);
  if (numbers.empty()) numbers = unit_numbers(past, means);
  add_population(past, means, request, numbers, estimate);
  state(estimate, numbers);
  estimate.provenance.settings["units"] = fmt::format("{}", past.units);
  std::vector<Link> links;
  estimate.curves = units_curves(past, means, estimate.tables, links);
  estimate.tables.push_back(links_table(links, past.results.over.shown));
  if (past.errors.size() > 1)
    estimate.findings.push_back({Severity::info, "chart_sources_changed", {{"sets", past.errors.size()}}});
  return estimate;
}

}  // namespace tumble
