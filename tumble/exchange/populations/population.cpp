#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tumble/core/columns.hpp"
#include "tumble/exchange/populations.hpp"
#include "tumble/exchange/populations/keyed.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/language/text.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/population/outliers.hpp"
#include "tumble/math/population/spread.hpp"
#include "tumble/math/population/vector_population.hpp"
#include "tumble/math/square.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/prior_rows.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using populations::SharedErrors;
using Severity = Finding::Severity;

constexpr std::size_t least_units = 5, many_units = 10;
constexpr double false_outliers = 0.01;

/// Units that are used, and results that are not.
struct Gathered {
  std::vector<TestedUnit> units;
  std::vector<std::pair<std::string, Sentence>> left_out;  ///< unit, why

  /// Removes the units of which `unfit` is true.
  template <class Unfit>
  void leave_out(const Sentence& why, const Unfit& unfit) {
    std::erase_if(units, [&](const TestedUnit& unit) {
      if (!unfit(unit)) return false;
      left_out.emplace_back(unit.serial, why);
      return true;
    });
  }
};

std::vector<double> values_of(const Estimate& estimate) {
  std::vector<double> values;
  for (const auto& parameter : estimate.parameters) values.push_back(parameter.value);
  return values;
}

/// Parameters of another dimension than in most units.
void note_other_dimensions(Gathered& all, const std::vector<Parameter>& parameters) {
  for (const auto& unit : all.units)
    for (const auto& parameter : unit.estimate.parameters)
      if (const auto same = std::ranges::find(parameters, parameter.name, &Parameter::name);
          same != parameters.end() && same->unit.dimension() != parameter.unit.dimension())
        all.left_out.emplace_back(unit.serial, say("{} is in {}, in most units in {}", Name{parameter.name},
                                                   Name{parameter.unit.text()}, Name{same->unit.text()}));
}

/// Simulated results beside measured ones, and one result under two serial numbers.
void leave_out_strangers(Gathered& all) {
  const auto simulated = static_cast<std::size_t>(std::ranges::count_if(all.units, &TestedUnit::simulated));
  if (simulated > 0 && simulated < all.units.size())
    all.leave_out("simulated", [](const TestedUnit& unit) { return unit.simulated; });
  std::set<std::vector<double>> seen;
  all.leave_out("the same values as another unit",
                [&](const TestedUnit& unit) { return !seen.insert(values_of(unit.estimate)).second; });
}

/// A parameter as results mean it: its name, and the terms in it that no five units show by themselves.
struct Meaning {
  std::string name, contained;
  bool operator<(const Meaning& other) const {
    return std::tie(name, contained) < std::tie(other.name, other.contained);
  }
};

/// Names that five units show by themselves.
std::vector<std::string> pure_names(const std::vector<TestedUnit>& units) {
  std::map<std::string, std::size_t> shown;
  for (const auto& unit : units)
    for (std::size_t i = 0; i < unit.estimate.parameters.size(); ++i)
      if (unit.estimate.parameters[i].contains.empty() && prior_rows::is_normal(unit.estimate, i))
        ++shown[unit.estimate.parameters[i].name];
  std::vector<std::string> names;
  for (const auto& [name, count] : shown)
    if (count >= least_units) names.push_back(name);
  return names;
}

/// Whether a row is its parameter with nothing else of the population in it.
bool is_alone(const Parameter& parameter, const std::vector<std::string>& pure) {
  return std::ranges::none_of(parameter.contains, [&](const Parameter::Contained& term) {
    return std::ranges::find(pure, term.name) != pure.end();
  });
}

/// The parameters of the population: of each name the meaning and dimension that most units show, five at least.
std::vector<Parameter> parameters_of(const std::vector<TestedUnit>& units, const std::vector<std::string>& pure) {
  struct Candidate {
    std::size_t count = 0;
    Parameter parameter;
  };
  std::map<Meaning, std::map<std::string, Candidate>> found;  // by meaning and dimension
  std::vector<std::string> order;
  for (const auto& unit : units)
    for (std::size_t i = 0; i < unit.estimate.parameters.size(); ++i) {
      const auto& parameter = unit.estimate.parameters[i];
      if (!prior_rows::is_normal(unit.estimate, i) || !is_alone(parameter, pure)) continue;
      auto& candidate =
          found[{parameter.name, prior_rows::unresolved(parameter, pure)}][name(parameter.unit.dimension())];
      if (candidate.count++ == 0) candidate.parameter = parameter;
      if (std::ranges::find(order, parameter.name) == order.end()) order.push_back(parameter.name);
    }
  std::map<std::string, Candidate> best;
  for (const auto& [meaning, by_dimension] : found)
    for (const auto& [dimension, candidate] : by_dimension)
      if (auto& one = best[meaning.name]; candidate.count > one.count) one = candidate;
  std::vector<Parameter> parameters;
  for (const auto& name : order)
    if (best[name].count >= least_units) parameters.push_back(best[name].parameter);
  return parameters;
}

/// The rows of a unit that speak of the population's parameters.
struct UnitRows {
  std::vector<std::size_t> which;
  std::vector<std::vector<double>> weights;
};

UnitRows rows_of(const Estimate& estimate, const std::vector<Parameter>& parameters) {
  UnitRows rows;
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const auto& parameter = estimate.parameters[i];
    const auto same = std::ranges::find(parameters, parameter.name, &Parameter::name);
    if (same == parameters.end() || !prior_rows::is_normal(estimate, i) ||
        same->unit.dimension() != parameter.unit.dimension())
      continue;
    auto row = prior_rows::row_of(parameter, parameters);
    if (!row.known) continue;
    rows.which.push_back(i);
    rows.weights.push_back(std::move(row.weights));
  }
  return rows;
}

/// What the units show, as the mathematics has it.
struct Shown {
  SharedErrors shared;
  std::vector<ShownOfUnit> units;
};

Shown shown_of(const std::vector<TestedUnit>& units, const std::vector<Parameter>& parameters) {
  std::vector<const Estimate*> estimates;
  for (const auto& unit : units) estimates.push_back(&unit.estimate);
  Shown out{SharedErrors(estimates), {}};
  for (const auto& unit : units) {
    const auto rows = rows_of(unit.estimate, parameters);
    ShownOfUnit shown{Matrix(rows.which.size(), parameters.size()),
                      {},
                      out.shared.private_of(unit.estimate, rows.which),
                      out.shared.columns_of(unit.estimate, rows.which)};
    for (std::size_t i = 0; i < rows.which.size(); ++i) {
      shown.values.push_back(unit.estimate.parameters[rows.which[i]].value);
      for (std::size_t k = 0; k < parameters.size(); ++k) shown.combinations(i, k) = rows.weights[i][k];
    }
    out.units.push_back(std::move(shown));
  }
  return out;
}

/// Values of parameter k by itself, with the numbers of their units.
std::vector<std::pair<std::size_t, UnitValue>> values_alone(const Shown& shown, std::size_t k) {
  std::vector<std::pair<std::size_t, UnitValue>> values;
  for (std::size_t u = 0; u < shown.units.size(); ++u) {
    const auto& unit = shown.units[u];
    for (std::size_t i = 0; i < unit.values.size(); ++i) {
      bool alone = unit.combinations(i, k) == 1.0;
      for (std::size_t j = 0; j < unit.combinations.columns; ++j)
        alone = alone && (j == k || unit.combinations(i, j) == 0.0);
      if (alone) values.emplace_back(u, UnitValue{unit.values[i], std::sqrt(unit.covariance(i, i))});
    }
  }
  return values;
}

std::vector<UnitValue> without_numbers(const std::vector<std::pair<std::size_t, UnitValue>>& values) {
  std::vector<UnitValue> out;
  for (const auto& [unit, value] : values) out.push_back(value);
  return out;
}

/// A value of a unit that does not belong to the others.
struct OutlierValue {
  std::string serial, parameter;
  double z, p;
  std::size_t unit;  ///< its number
};

/// Values that do not belong to those of the other units (8.29).
std::vector<OutlierValue> outliers(const std::vector<TestedUnit>& units, const std::vector<Parameter>& parameters) {
  std::vector<OutlierValue> all;
  const Shown shown = shown_of(units, parameters);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto values = values_alone(shown, k);
    const auto found = outlier_units(without_numbers(values), false_outliers / static_cast<double>(parameters.size()));
    for (std::size_t i = 0; i < values.size(); ++i)
      if (found.outlier[i])
        all.push_back({units[values[i].first].serial, parameters[k].name, found.z[i], found.p[i], values[i].first});
  }
  return all;
}

/// A number in the unit of a parameter, as text.
std::string text_in(const Parameter& parameter, double si) {
  return general(parameter.unit.difference_from_si(si), 3) + " " + parameter.unit.text();
}

/// Table of the parameters, with the interval of each spread (8.4).
Table population_table(const std::vector<Parameter>& parameters, const Shown& shown, const VectorPopulation& found,
                       std::vector<std::string>& below_stated) {
  struct Row {
    const Parameter& parameter;
    std::size_t units;
    UnitSpread spread;
    double sd, typical;  ///< [SI]

    std::string text(double si) const { return text_in(parameter, si); }
  };
  std::vector<Row> rows;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto values = without_numbers(values_alone(shown, k));
    std::vector<double> sds;
    for (const auto& value : values) sds.push_back(value.sd);
    rows.push_back({parameters[k], values.size(), spread_of_units(values), std::sqrt(found.expected_spread(k, k)),
                    median(std::move(sds))});
    if (rows.back().spread.below_stated) below_stated.push_back(parameters[k].name);
  }
  return tabulate(
      "population",
      "spread of the true values of each parameter with its 95 % interval, beside the private uncertainty of a "
      "result",
      rows,
      {{"parameter", [](const Row& r) { return r.parameter.name; }},
       {"units", &Row::units},
       {"spread", [](const Row& r) { return r.text(r.sd); }},
       {"lower", [](const Row& r) { return r.text(r.spread.sd_lower); }},
       {"upper", [](const Row& r) { return r.text(r.spread.sd_upper); }},
       {"median_sd", [](const Row& r) { return r.text(r.typical); }},
       {"spread/sd", [](const Row& r) { return general(r.sd / r.typical, 3); }}});
}

/// Lines of the budget of a further unit.
std::vector<ErrorLine> lines_of(const VectorPopulation& found, const SharedErrors& shared) {
  std::vector<ErrorLine> lines{from_covariance("unit to unit", found.expected_spread)};
  const Matrix own = found.mean_covariance - found.shared * transposed(found.shared);
  lines.push_back(
      from_covariance("mean of the units tested", own, diagonal_of(found.expected_spread + found.mean_covariance)));
  for (const auto& [key, place] : shared.keys())
    lines.push_back(
        from_shifts(key.first, block(found.shared, 0, found.shared.rows, place.first, place.second), key.second));
  return lines;
}

std::string hash_of(const std::string& model, const std::string& method, const std::vector<TestedUnit>& units) {
  std::vector<std::string> hashes;
  for (const auto& unit : units) hashes.push_back(unit.sha256);
  std::ranges::sort(hashes);
  return sha256_of(fmt::format("{}\n{}\n{}\n", model, method, fmt::join(hashes, "\n")));
}

void refuse_few(const std::string& model, const std::string& method, const Gathered& all) {
  if (all.units.size() >= least_units) return;
  const std::size_t count = all.units.size();
  Problems problems{
      count == 1
          ? say("a population needs five units or more: there is {} of the model '{}' with a result of {} that can be "
                "used",
                count, model, Name{method})
          : say("a population needs five units or more: there are {} of the model '{}' with a result of {} that can be "
                "used",
                count, model, Name{method})};
  for (const auto& [unit, why] : all.left_out) problems.push_back(say("unit {} is not used: {}", Name{unit}, why));
  throw Error(Error::Kind::bad_data, problems);
}

void add_findings(const Gathered& all, const std::vector<OutlierValue>& outliers, Estimate& out) {
  if (all.units.size() < many_units)
    out.findings.push_back({Severity::warning, "prior_of_few_units", {{"units", all.units.size()}}});
  std::set<std::string> names;
  for (const auto& one : outliers) names.insert(one.serial);
  if (!names.empty())
    out.findings.push_back(
        {Severity::warning, "population_outliers", {{"units", fmt::format("{}", fmt::join(names, ", "))}}});
  if (!all.left_out.empty())
    out.findings.push_back({Severity::info, "results_left_out", {{"number", all.left_out.size()}}});
  std::vector<const Estimate*> results;
  for (const auto& unit : all.units) results.push_back(&unit.estimate);
  for (auto& finding : rig_keys::about_keys(results)) out.findings.push_back(std::move(finding));
  if (all.units.front().simulated) out.findings.push_back({Severity::info, "population_simulated", {}});
}

/// Removes the units that do not belong to the others, unless too few would remain. Returned: those of their values
/// that show it.
std::vector<OutlierValue> leave_out_outliers(Gathered& all) {
  const auto found = outliers(all.units, parameters_of(all.units, pure_names(all.units)));
  std::set<std::size_t> strange;
  for (const auto& one : found) strange.insert(one.unit);
  if (all.units.size() < least_units + strange.size()) return {};
  std::vector<TestedUnit> kept;
  for (std::size_t u = 0; u < all.units.size(); ++u)
    if (!strange.contains(u)) kept.push_back(std::move(all.units[u]));
  all.units = std::move(kept);
  return found;
}

/// Values, covariance, budget and table of the parameters of these units.
Estimate population_estimate(const std::vector<TestedUnit>& units, const std::vector<Parameter>& parameters) {
  const Shown shown = shown_of(units, parameters);
  const auto found = vector_population(shown.units);
  Estimate out;
  out.method = "population";
  out.parameters = parameters;
  for (std::size_t k = 0; k < parameters.size(); ++k) out.parameters[k].value = found.mean[k];
  settle(out, lines_of(found, shown.shared));
  for (auto& parameter : out.parameters) parameter.degrees_of_freedom = static_cast<double>(units.size()) - 1.0;
  out.population = PopulationFacts{{}, {}, units.size(), found.shrinkage, found.inflation};
  std::vector<std::string> below_stated;
  out.tables.push_back(population_table(parameters, shown, found, below_stated));
  if (!below_stated.empty())
    out.findings.push_back({Severity::warning,
                            "population_below_stated",
                            {{"parameters", fmt::format("{}", fmt::join(below_stated, ", "))}}});
  return out;
}

}  // namespace

std::string unfit_for_population(const Estimate& estimate) {
  if (estimate.prior) return "result_with_prior";
  for (const auto& finding : estimate.findings) {
    if (finding.code == "budget_without_factors") return "result_without_factors";
    if (finding.severity == Severity::error && !is_about_limit(finding)) return "result_in_error";
  }
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i)
    if (prior_rows::is_normal(estimate, i)) return {};
  return "result_without_normal";
}

Estimate population_of_units(const std::string& model, const std::string& method, std::vector<TestedUnit> units,
                             std::vector<ResultLeftOut> left_out) {
  Gathered all{std::move(units), {}};
  for (const auto& one : left_out)
    all.left_out.emplace_back(one.serial, Sentence(text_of("population", one.why).c_str()));
  leave_out_strangers(all);
  std::ranges::sort(all.units, {}, &TestedUnit::serial);  // the order of the rows says nothing
  refuse_few(model, method, all);
  const auto outliers = leave_out_outliers(all);
  const auto parameters = parameters_of(all.units, pure_names(all.units));
  if (parameters.empty())
    throw Error(Error::Kind::bad_data,
                say("no parameter of {} is shown by five units of the model '{}' by itself", Name{method}, model));
  note_other_dimensions(all, parameters);
  Estimate out = population_estimate(all.units, parameters);
  out.title = fmt::format("Population of {} units of {} by {}", all.units.size(), model, method);
  out.instrument_model = model;
  out.population->method = method;
  out.population->sha256 = hash_of(model, method, all.units);
  for (const auto& unit : all.units) out.provenance.inputs.push_back({model + "/" + unit.serial, unit.sha256});
  add_unless_empty(out.tables,
                   tabulate("outliers", "units that do not belong to the others; they are not used", outliers,
                            {{"unit", &OutlierValue::serial},
                             {"parameter", &OutlierValue::parameter},
                             {"z", &OutlierValue::z},
                             {"p", &OutlierValue::p}}));
  if (!all.left_out.empty()) out.tables.push_back(populations::left_out_table(all.left_out));
  add_findings(all, outliers, out);
  return out;
}

}  // namespace tumble
