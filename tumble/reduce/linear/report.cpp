#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/linear/words.hpp"
#include "tumble/units/error.hpp"

namespace tumble::linear {
namespace {

/// " + D_OO", " - 0.5 D_OO" for a weight in the units shown.
std::string signed_term(double weight, const std::string& name) {
  const double size = std::abs(weight);
  const std::string factor = std::abs(size - 1.0) < 0.005 ? "" : fmt::format("{:.3g} ", size);
  return (weight < 0.0 ? " - " : " + ") + factor + name;
}

double shown_weight(double weight, const Term& kept, const Term& dropped) {
  return weight * Unit::parse(dropped.unit).factor() / Unit::parse(kept.unit).factor();
}

std::string listed(const std::vector<std::string>& names) {
  if (names.size() < 2) return names.empty() ? "" : names.front();
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

std::string with_advice(const std::string& text, const Problem& problem) {
  return problem.advice.empty() ? text : text + "; " + problem.advice;
}

Finding combination(const Problem& problem, const Dropped& dropped, Solution& solution) {
  const Term& out = problem.columns[dropped.column];
  std::vector<std::string> others, meanings;
  for (std::size_t k = 0; k < problem.columns.size(); ++k) {
    if (dropped.weights[k] == 0.0) continue;
    const Term& kept = problem.columns[k];
    const auto term = signed_term(shown_weight(dropped.weights[k], kept, out), out.name);
    solution.stands_for.try_emplace(kept.name, kept.name).first->second += term;
    others.push_back(kept.name);
    meanings.push_back(fmt::format("{0} stands for {0}{1}", kept.name, term));
  }
  return {Finding::Severity::warning,
          with_advice(fmt::format("{} cannot be told apart from {} with this evidence: {} is set to zero, so {}",
                                  out.name, listed(others), out.name, listed(meanings)),
                      problem),
          ""};
}

Unit unit_of(const Term& term) { return Unit::parse(term.unit); }

}  // namespace

void warn_of_misfit(const Solution& solution, const std::string& channel_unit, Findings& findings) {
  std::vector<double> noise;
  double largest = 0.0;
  for (const auto& segment : solution.segments) {
    noise.push_back(segment.sd);
    largest = std::max(largest, std::abs(segment.predicted));
  }
  if (noise.empty()) return;
  std::ranges::nth_element(noise, noise.begin() + static_cast<std::ptrdiff_t>(noise.size() / 2));
  const double usual = noise[noise.size() / 2];
  if (!(solution.drift_sd > 30.0 * usual) || solution.drift_sd < 1e-9 * largest) return;  // the latter is rounding
  findings.push_back(
      {Finding::Severity::warning,
       fmt::format("the segments differ from the model by {}, {:.0f} times what the noise within them explains: is the "
                   "scale factor right, its sign too, are the segments where the plan says, is the output clipped? The "
                   "uncertainties count this as drift",
                   say_difference(solution.drift_sd, Unit::parse(channel_unit)), solution.drift_sd / usual),
       ""});
}

void warn_of_excess(const Problem& problem, double stated, Solution& solution) {
  if (!(stated > 0.0)) return;
  const std::size_t segments = solution.segments.size(), columns = solution.columns.size();
  const double freedom = segments > columns ? static_cast<double>(segments - columns) : 1.0;
  std::vector<double> noise;
  for (const auto& segment : solution.segments) noise.push_back(segment.sd);
  const double expected = std::hypot(stated, median(noise));
  const double times = std::hypot(solution.drift_sd, expected) / expected;
  // seldom where the statement is right: what else moves segments counts as well
  if (times * times < std::max(3.0, chi_square_quantile(0.9999, freedom) / freedom)) return;
  solution.findings.push_back(
      {Finding::Severity::warning,
       fmt::format(
           "{}: the segments differ {:.2g} times as much as noise and the bias instability stated let expect: is "
           "it right, in its unit too? The uncertainties count the rest as drift, as far as the segments show it",
           problem.role, times),
       ""});
}

void describe_dropped(const Problem& problem, Solution& solution) {
  std::vector<std::string> empty;
  for (const auto& dropped : solution.dropped) {
    if (std::ranges::all_of(dropped.weights, [](double w) { return w == 0.0; }))
      empty.push_back(problem.columns[dropped.column].name);
    else
      solution.findings.push_back(combination(problem, dropped, solution));
  }
  if (!empty.empty()) {
    std::ranges::sort(empty);
    solution.findings.push_back({Finding::Severity::info,
                                 fmt::format("nothing in this evidence shows {}: left out of the model", listed(empty)),
                                 ""});
  }
}

std::vector<Term> terms_of(const std::string& model, const Settings& constants, const std::vector<std::string>& names) {
  std::vector<Term> terms;
  const auto outputs = find_model(model).outputs(constants);
  for (const auto& name : names)
    for (const auto& output : outputs)
      for (const auto& term : output.terms)
        if (term.name == name) terms.push_back(term);
  if (terms.size() != names.size()) throw Error(Error::Kind::internal, "model " + model + " lacks a term asked for");
  return terms;
}

std::vector<Option> options(const std::string& settling, const std::string& averaging) {
  using Type = Option::Type;
  return {
      {"settling", Type::quantity, "s", settling, {}, "time dropped in each segment after the rig has settled"},
      {"averaging",
       Type::quantity,
       "s",
       averaging,
       {},
       "length of the averages that are fitted; where the rig moves, at most a tenth of a period"},
      {"oversampling", Type::integer, "1", "1", {}, "instants within each sample at which a moving rig is computed"}};
}

Option bias_instability_option(const std::string& unit, const std::string& prefix) {
  return {prefix + "bias_instability",
          Option::Type::quantity,
          unit,
          "",
          {},
          "B as a noise test found it (IEEE 528; the flat part of the Allan deviation is 0.664 B): part of the fit, so "
          "that few segments need not show it; absent: found from the segments",
          true};
}

double stated_bias_instability(const Settings& settings, const std::string& prefix,
                               std::vector<std::string>& problems) {
  const std::string name = prefix + "bias_instability";
  if (!settings.has(name)) return 0.0;
  const double stated = settings.number(name);
  if (!(stated > 0.0)) problems.push_back(fmt::format("[settings] {} must be above zero, or absent", name));
  return stated;
}

void set_options(const Settings& settings, Problem& problem, const std::string& noise_prefix) {
  problem.settling = settings.number("settling");
  problem.averaging = settings.number("averaging");
  problem.oversampling = settings.integer("oversampling");
  std::vector<std::string> problems;
  if (problem.settling < 0.0) problems.push_back("[settings] settling must not be negative");
  if (!(problem.averaging > 0.0)) problems.push_back("[settings] averaging must be above zero");
  if (problem.oversampling < 1 || problem.oversampling > 1000)
    problems.push_back("[settings] oversampling must be from 1 to 1000");
  problem.stated_by = noise_prefix + "bias_instability";
  problem.bias_instability = stated_bias_instability(settings, noise_prefix, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

Estimate estimate_of(const Solution& solution) {
  Estimate estimate;
  const auto& fit = solution.fit;
  const std::size_t p = solution.columns.size();
  for (std::size_t j = 0; j < p; ++j) {
    const Term& term = solution.columns[j];
    std::vector<double> unit(p, 0.0);
    unit[j] = 1.0;
    const auto meaning = solution.stands_for.find(term.name);
    estimate.parameters.push_back(
        {term.name, term.symbol, unit_of(term), fit.parameters[j],
         term.description + (meaning == solution.stands_for.end() ? "" : "; stands for " + meaning->second),
         degrees_of_freedom(fit, unit)});
  }
  estimate.covariance = fit.covariance;
  for (const auto& source : fit.sources) {
    auto line = std::ranges::find(estimate.budget, source.source, &Contribution::source);
    if (line == estimate.budget.end())
      line = estimate.budget.insert(line, {source.source, std::vector<double>(p, 0.0)});
    for (std::size_t j = 0; j < p; ++j) line->variance[j] += source.covariance(j, j);
  }
  estimate.fit = {solution.observations, fit.degrees_of_freedom, fit.chi_square, fit.condition};
  estimate.findings = solution.findings;
  return estimate;
}

Table positions(const Solution& solution, const std::string& channel_unit, const std::vector<std::string>& axes,
                const std::string& rate_unit) {
  const Unit unit = Unit::parse(channel_unit), g = Unit::parse("g"), seconds = Unit::parse("s");
  Table table{
      "positions", "what was felt, predicted and measured in each segment (means over the samples used)", {}, {}};
  table.columns = {{"label", Unit()}, {"run", Unit()}, {"duration", seconds}};
  for (const auto& axis : axes) table.columns.push_back({"f_" + axis, g});
  if (!rate_unit.empty())
    for (const auto& axis : axes) table.columns.push_back({"w_" + axis, Unit::parse(rate_unit)});
  const bool measured = std::ranges::none_of(solution.segments, [](const auto& s) { return std::isnan(s.measured); });
  for (const char* name : {"predicted", "noise_sd"}) table.columns.push_back({name, unit});
  if (measured)
    for (const char* name : {"measured", "residual"}) table.columns.push_back({name, unit});
  for (const auto& segment : solution.segments) {
    std::vector<Table::Cell> row{segment.label, static_cast<double>(segment.run), segment.duration};
    const auto add = [&](Vector3 v) {
      const double rounding = 1e-14 * norm(v);  // cosines of 90 deg
      for (const double one : {v.x, v.y, v.z}) row.emplace_back(std::abs(one) < rounding ? 0.0 : one);
    };
    add(segment.felt.specific_force);
    if (!rate_unit.empty()) add(segment.felt.rate);
    row.insert(row.end(), {segment.predicted, segment.sd});
    if (measured) row.insert(row.end(), {segment.measured, segment.measured - segment.predicted});
    table.rows.push_back(std::move(row));
  }
  return table;
}

Estimate answer_of(const Solution& solution, const std::string& method, const std::string& channel_unit,
                   const std::vector<std::string>& axes, const std::string& rate_unit) {
  Estimate estimate = estimate_of(solution);
  estimate.method = method;
  estimate.tables.push_back(positions(solution, channel_unit, axes, rate_unit));
  warn_of_misfit(solution, channel_unit, estimate.findings);
  return estimate;
}

}  // namespace tumble::linear
