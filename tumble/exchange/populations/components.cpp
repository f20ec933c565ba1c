#include "tumble/math/population/components.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/core/budget.hpp"
#include "tumble/core/columns.hpp"
#include "tumble/exchange/populations.hpp"
#include "tumble/exchange/populations/keyed.hpp"
#include "tumble/language/text.hpp"
#include "tumble/math/population/spread.hpp"
#include "tumble/math/square.hpp"
#include "tumble/reduce/prior_rows.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Severity = Finding::Severity;
using Levels = std::vector<std::size_t>;

/// Levels numbered from 0 in the order of their first result.
Levels numbered_by(const std::vector<std::string>& names) {
  std::map<std::string, std::size_t> known;
  Levels out;
  for (const auto& name : names) out.push_back(known.try_emplace(name, known.size()).first->second);
  return out;
}

std::size_t count_of(const Levels& levels) { return levels.empty() ? 0 : 1 + *std::ranges::max_element(levels); }

/// The factors that these results can separate, and what the names of the others mean then.
struct Separable {
  std::vector<ResultFactor> factors;
  std::string unit = "unit", turn_on = "turn_on";  ///< names of the first and of the last component
  Findings findings;
};

Separable separable(const std::vector<OccasionResult>& results) {
  std::vector<std::string> units, days, rigs;
  bool days_known = true, rigs_known = true;
  for (const auto& one : results) {
    units.push_back(one.serial);
    days.push_back(one.serial + " " + one.day);
    rigs.push_back(one.rig);
    days_known = days_known && !one.day.empty();
    rigs_known = rigs_known && !one.rig.empty();
  }
  const auto unit = numbered_by(units), day = numbered_by(days), rig = numbered_by(rigs);
  Separable out;
  const auto say = [&](const char* code) { out.findings.push_back({Severity::info, code, {}}); };
  out.factors.push_back({"unit", unit});
  const bool days_within = days_known && day != unit;
  if (!days_known)
    say("day_not_known"), out.turn_on = "day_and_turn_on";
  else if (day == unit)
    say("one_day_a_unit"), out.unit = "unit_and_day";
  else if (count_of(day) == results.size())
    say("one_result_a_day"), out.turn_on = "day_and_turn_on";
  else
    out.factors.push_back({"day", day});
  if (!rigs_known)
    say("rig_not_known");
  else if (count_of(rig) < 2)
    say("one_rig");
  else if (rig == unit || (days_within && rig == day))
    say("rig_not_separated");
  else if (count_of(rig) < results.size())
    out.factors.push_back({"rig", rig});
  return out;
}

void require_enough(const std::string& model, const std::string& parameter, const std::vector<OccasionResult>& results,
                    const std::vector<std::string>& others) {
  std::vector<std::string> units;
  for (const auto& one : results) units.push_back(one.serial);
  Problems problems;
  if (results.size() < 4)
    problems.push_back(
        say("components need at least four results of the model '{}' with the parameter '{}'; there are {}{}", model,
            parameter, results.size(), did_you_mean(parameter, others)));
  else if (count_of(numbered_by(units)) < 3)
    problems.push_back(say("components need at least three units; the results of '{}' are of {}", parameter,
                           count_of(numbered_by(units))));
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

/// Number of the parameter in a result; the number of parameters: it is not there, or not by itself.
std::size_t place_of(const Estimate& estimate, const std::string& parameter) {
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i)
    if (estimate.parameters[i].name == parameter && estimate.parameters[i].contains.empty() &&
        prior_rows::is_normal(estimate, i))
      return i;
  return estimate.parameters.size();
}

ManyResults many_results(const std::vector<OccasionResult>& results, const std::string& parameter,
                         std::vector<ResultFactor> factors) {
  std::vector<const Estimate*> estimates;
  for (const auto& one : results) estimates.push_back(&one.estimate);
  const populations::SharedErrors shared(estimates);
  ManyResults out;
  out.factors = std::move(factors);
  out.shared = Matrix(results.size(), shared.draws());
  for (std::size_t r = 0; r < results.size(); ++r) {
    const std::vector<std::size_t> row{place_of(results[r].estimate, parameter)};
    out.values.push_back(results[r].estimate.parameters[row[0]].value);
    out.sds.push_back(std::sqrt(shared.private_of(results[r].estimate, row)(0, 0)));
    const Matrix columns = shared.columns_of(results[r].estimate, row);
    for (std::size_t k = 0; k < columns.columns; ++k) out.shared(r, k) = columns(0, k);
  }
  if (shared.draws() == 0) out.shared = {};
  return out;
}

/// One result a unit: all that differs between the results is one component.
SpreadComponents of_single_results(const ManyResults& many) {
  std::vector<UnitValue> values;
  for (std::size_t r = 0; r < many.values.size(); ++r) values.push_back({many.values[r], many.sds[r]});
  const auto found = spread_of_units(values);
  SpreadComponents out;
  out.components.push_back(
      {"unit", found.sd, found.sd_lower, found.sd_upper, static_cast<double>(values.size()) - 1.0});
  out.mean = found.mean, out.mean_sd = found.mean_sd;
  out.degrees_of_freedom = static_cast<double>(values.size()) - 1.0;
  double shared = 0.0;  // of the mean with equal weights: an upper limit where the units are on several rigs
  for (std::size_t k = 0; k < many.shared.columns; ++k) {
    double shift = 0.0;
    for (std::size_t r = 0; r < many.shared.rows; ++r)
      shift += many.shared(r, k) / static_cast<double>(many.shared.rows);
    shared += square(shift);
  }
  out.mean_sd = std::sqrt(square(out.mean_sd) + shared);
  return out;
}

Parameter component_parameter(const Parameter& of, const ComponentOfSpread& one, const std::string& name) {
  Parameter out;
  out.name = of.name + "_" + name + "_sd";
  out.unit = of.unit;
  out.value = one.sd;
  out.description =
      fmt::format("standard deviation of {} from {}", of.name, text_of("population", "component_" + name));
  out.degrees_of_freedom = one.degrees_of_freedom;
  out.lower = one.lower, out.upper = one.upper;
  return out;
}

Table components_table(const Parameter& of, const SpreadComponents& found, const Separable& by,
                       const std::vector<std::string>& names, std::size_t results) {
  const auto levels = [&](std::size_t c) { return c < by.factors.size() ? count_of(by.factors[c].level) : results; };
  return tabulate("components",
                  "standard deviation from each source with its 95 % interval, degrees of freedom, levels and results",
                  names.size(),
                  {{"source", [&](std::size_t c) { return text_of("population", "component_" + names[c]); }},
                   {"sd", of.unit, [&](std::size_t c) { return found.components[c].sd; }},
                   {"lower", of.unit, [&](std::size_t c) { return found.components[c].lower; }},
                   {"upper", of.unit, [&](std::size_t c) { return found.components[c].upper; }},
                   {"degrees", [&](std::size_t c) { return found.components[c].degrees_of_freedom; }},
                   {"levels", levels},
                   {"results", [results](std::size_t) { return results; }}});
}

/// All results over time, a curve of points for each of the first units.
void add_curves(const std::vector<OccasionResult>& results, const std::string& parameter, Estimate& out) {
  constexpr std::size_t most_units = 12;
  double first = INFINITY;
  for (const auto& one : results) first = std::min(first, one.moment);
  std::map<std::string, Curve> curves;
  for (const auto& one : results) {
    Curve empty{.name = one.serial,
                .figure = "results",
                .x = {"time since the first result", Unit::parse("day")},
                .y = {parameter, out.parameters.front().unit},
                .points = true};
    add_point(curves.try_emplace(one.serial, std::move(empty)).first->second, one.moment - first,
              one.estimate.parameters[place_of(one.estimate, parameter)].value);
  }
  for (auto& [serial, curve] : curves)
    if (out.curves.size() < most_units) out.curves.push_back(std::move(curve));
}

/// Removes the results that do not show the parameter by itself; `others`: the parameters that they have.
void keep_those_with(const std::string& parameter, std::vector<OccasionResult>& results,
                     std::vector<std::pair<std::string, Sentence>>& not_used, std::vector<std::string>& others) {
  std::erase_if(results, [&](const OccasionResult& one) {
    if (place_of(one.estimate, parameter) < one.estimate.parameters.size()) return false;
    for (const auto& other : one.estimate.parameters)
      if (std::ranges::find(others, other.name) == others.end()) others.push_back(other.name);
    not_used.emplace_back(one.serial, Sentence(text_of("population", "without_parameter").c_str()));
    return true;
  });
}

/// Values, covariance and table of the components.
Estimate components_estimate(const Parameter& of, const SpreadComponents& found, const Separable& by,
                             const std::vector<std::string>& names, std::size_t results) {
  Estimate out;
  out.method = "components";
  Parameter mean = of;
  mean.name = of.name + "_mean", mean.value = found.mean, mean.degrees_of_freedom = found.degrees_of_freedom;
  mean.description = "mean of the units";
  out.parameters.push_back(mean);
  std::vector<double> variances{square(found.mean_sd)};
  for (std::size_t c = 0; c < names.size(); ++c) {
    out.parameters.push_back(component_parameter(of, found.components[c], names[c]));
    variances.push_back(square((found.components[c].upper - found.components[c].lower) / (2.0 * 1.959964)));
  }
  out.budget.push_back(independent_errors("scatter of the results", variances));
  out.covariance = covariance_of(out.budget, variances.size());
  out.findings = by.findings;
  out.tables.push_back(components_table(of, found, by, names, results));
  return out;
}

/// Leaves out results in which the parameter has another dimension than in most of them.
void keep_dimension(const std::string& parameter, std::vector<OccasionResult>& results,
                    std::vector<std::pair<std::string, Sentence>>& not_used) {
  const auto unit_of = [&](const OccasionResult& one) {
    return one.estimate.parameters[place_of(one.estimate, parameter)].unit;
  };
  const auto as_many_as = [&](const Dimension& dimension) {
    return std::ranges::count_if(results, [&](const auto& one) { return unit_of(one).dimension() == dimension; });
  };
  if (results.empty() || as_many_as(unit_of(results.front()).dimension()) == std::ssize(results)) return;
  Unit most = unit_of(results.front());
  for (const auto& one : results)
    if (as_many_as(unit_of(one).dimension()) > as_many_as(most.dimension())) most = unit_of(one);
  std::erase_if(results, [&](const OccasionResult& one) {
    if (unit_of(one).dimension() == most.dimension()) return false;
    not_used.emplace_back(one.serial, say("{} is in {}, in most results in {}", Name{parameter},
                                          Name{unit_of(one).text()}, Name{most.text()}));
    return true;
  });
}

}  // namespace

Estimate components_of_results(const std::string& model, const std::string& parameter,
                               std::vector<OccasionResult> results, std::vector<ResultLeftOut> left_out) {
  std::vector<std::pair<std::string, Sentence>> not_used;
  for (const auto& one : left_out) not_used.emplace_back(one.serial, Sentence(text_of("population", one.why).c_str()));
  std::vector<std::string> others;
  keep_those_with(parameter, results, not_used, others);
  keep_dimension(parameter, results, not_used);
  require_enough(model, parameter, results, others);
  std::ranges::sort(results, [](const OccasionResult& a, const OccasionResult& b) {
    return std::tie(a.serial, a.moment, a.sha256) < std::tie(b.serial, b.moment, b.sha256);
  });
  auto by = separable(results);
  const bool single = count_of(by.factors.front().level) == results.size();
  if (single)
    by.factors.resize(1), by.findings = {{Severity::info, "one_result_a_unit", {}}}, by.unit = "unit_day_and_turn_on";
  const auto many = many_results(results, parameter, by.factors);
  const auto found = single ? of_single_results(many) : components_of_spread(many);
  std::vector<std::string> names{by.unit};
  for (std::size_t c = 1; c < by.factors.size(); ++c) names.push_back(by.factors[c].name);
  if (!single) names.push_back(by.turn_on);

  const auto& first = results.front().estimate;
  Estimate out = components_estimate(first.parameters[place_of(first, parameter)], found, by, names, results.size());
  out.title = fmt::format("Components of {} of {}: {} results of {} units", parameter, model, results.size(),
                          count_of(by.factors.front().level));
  out.instrument_model = model;
  if (!not_used.empty()) {
    out.findings.push_back({Severity::info, "results_left_out", {{"number", not_used.size()}}});
    out.tables.push_back(populations::left_out_table(not_used));
  }
  add_curves(results, parameter, out);
  for (const auto& one : results) out.provenance.inputs.push_back({model + "/" + one.serial, one.sha256});
  return out;
}

}  // namespace tumble
