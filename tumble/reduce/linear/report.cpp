#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/linear/words.hpp"
#include "tumble/reduce/output_model.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::linear {
namespace {

constexpr double unit_weight = 0.005;  ///< [1] within which a weight of three digits is 1
/// [1] of the usual sd: drift decides the uncertainty, and the noise nothing.
constexpr double drift_over_noise = 30.0;

/// " + D_OO", " - 0.5 D_OO" for a weight in the units shown.
std::string signed_term(double weight, const std::string& name) {
  const double size = std::abs(weight);
  const std::string factor = std::abs(size - 1.0) < unit_weight ? "" : fmt::format("{:.3g} ", size);
  return (weight < 0.0 ? " - " : " + ") + factor + name;
}

double shown_weight(double weight, const Term& used, const Term& dropped) {
  return weight * Unit::parse(dropped.unit).factor() / Unit::parse(used.unit).factor();
}

Unit unit_of(const Term& term) { return Unit::parse(term.unit); }

bool is_empty(const Dropped& dropped) {
  return std::ranges::all_of(dropped.weights, [](double w) { return w == 0.0; });
}

Finding combination(const Problem& problem, const Dropped& dropped, Solution& solution) {
  const Term& out = problem.columns[dropped.column];
  std::vector<std::string> others, meanings;
  for (std::size_t k = 0; k < problem.columns.size(); ++k) {
    if (dropped.weights[k] == 0.0) continue;
    const Term& term = problem.columns[k];
    const auto share = signed_term(shown_weight(dropped.weights[k], term, out), out.name);
    solution.stands_for.try_emplace(term.name, term.name).first->second += share;
    solution.contains[term.name].push_back({out.name, unit_of(out), dropped.weights[k]});
    others.push_back(term.name);
    meanings.push_back(term.name + share);
  }
  return {severity_of(dropped, solution),
          "not_distinguished",
          {{"term", out.name}, {"others", joined(others)}, {"meanings", joined(meanings)}, {"advice", problem.advice}}};
}

}  // namespace

Finding::Severity severity_of(const Dropped& dropped, const Solution& solution) {
  const bool by_schedule =
      std::ranges::find(solution.hidden_by_schedule, dropped.column) != solution.hidden_by_schedule.end();
  return by_schedule ? Finding::Severity::info : Finding::Severity::warning;
}

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
  if (!(solution.drift_sd > drift_over_noise * usual) || solution.drift_sd < rounding_share * largest)
    return;  // the latter is rounding
  findings.push_back({Finding::Severity::warning,
                      "segments_differ_from_model",
                      {{"difference", solution.drift_sd, channel_unit}, {"times", solution.drift_sd / usual}}});
}

void describe_dropped(const Problem& problem, Solution& solution) {
  std::vector<std::string> empty;
  for (const auto& dropped : solution.dropped) {
    if (is_empty(dropped))
      empty.push_back(problem.columns[dropped.column].name);
    else
      solution.findings.push_back(combination(problem, dropped, solution));
  }
  if (empty.empty()) return;
  std::ranges::sort(empty);
  solution.findings.push_back(
      {Finding::Severity::info, "not_shown", {{"terms", joined(empty)}}, "", {empty.size(), empty.front(), {}}});
}

std::vector<Term> terms_of(const std::string& model, const Settings& constants, const std::vector<std::string>& names) {
  std::vector<Term> terms;
  const auto outputs = find_model(model).outputs(constants);
  for (const auto& name : names)
    for (const auto& output : outputs)
      for (const auto& term : output.terms)
        if (term.name == name) terms.push_back(term);
  if (terms.size() != names.size())
    throw Error(Error::Kind::internal, say("model {} lacks a term of the method", Name{model}));
  return terms;
}

std::vector<Option> options(const std::string& settling, const std::string& averaging) {
  return {quantity("settling", "s")
              .at_least(0)
              .otherwise(settling)
              .says("time after the rig has settled that is skipped in each segment"),
          quantity("averaging", "s")
              .above(0)
              .otherwise(averaging)
              .says("length of the averages that are fitted; where the rig moves, at most a tenth of a period"),
          integer("oversampling")
              .between(1, 1000)
              .otherwise("1")
              .says("least number of instants in each sample at which the motion of the rig is calculated")};
}

Option bias_instability_option(const std::string& unit, const std::string& prefix) {
  return quantity(prefix + "bias_instability", unit)
      .above(0)
      .bare()
      .says(
          "bias instability B from a noise test (IEEE 528; the flat part of the Allan deviation is 0.664 B), used in "
          "the fit because few segments do not show it; absent: it is estimated from the segments");
}

double stated_bias_instability(const Settings& settings, const std::string& prefix) {
  const std::string name = prefix + "bias_instability";
  return settings.has(name) ? settings.number(name) : 0.0;
}

void set_options(const Settings& settings, Problem& problem, const std::string& noise_prefix) {
  problem.settling = settings.number("settling");
  problem.averaging = settings.number("averaging");
  problem.oversampling = settings.integer("oversampling");
  problem.stated_by = noise_prefix + "bias_instability";
  problem.bias_instability = stated_bias_instability(settings, noise_prefix);
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
         term.description + (meaning == solution.stands_for.end() ? "" : "; means " + meaning->second),
         degrees_of_freedom(fit, unit)});
    if (j < solution.channels.size()) estimate.parameters.back().channels = {solution.channels[j]};
    if (const auto found = solution.contains.find(term.name); found != solution.contains.end())
      estimate.parameters.back().contains = found->second;
  }
  settle(estimate, lines_of(fit.sources));
  estimate.fit = {solution.observations, fit.degrees_of_freedom, fit.chi_square, fit.condition};
  estimate.findings = solution.findings;
  return estimate;
}

Vector3 without_rounding(Vector3 v) {
  const double rounding = 1e-14 * norm(v);  // cosines of 90 deg
  for (std::size_t i = 0; i < 3; ++i)
    if (std::abs(v[i]) < rounding) v[i] = 0.0;
  return v;
}

Table positions(const Solution& solution, const std::string& channel_unit, const std::vector<std::string>& axes,
                const std::string& rate_unit) {
  using Summary = SegmentSummary;
  const Unit unit = Unit::parse(channel_unit);
  std::vector<ColumnOf<Summary>> columns{
      {"label", &Summary::label}, {"run", &Summary::run}, {"duration", "s", &Summary::duration}};
  for (std::size_t i = 0; i < axes.size(); ++i)
    columns.emplace_back("f_" + axes[i], "g",
                         [i](const Summary& s) { return without_rounding(s.felt.specific_force)[i]; });
  for (std::size_t i = 0; i < axes.size() && !rate_unit.empty(); ++i)
    columns.emplace_back("w_" + axes[i], Unit::parse(rate_unit),
                         [i](const Summary& s) { return without_rounding(s.felt.rate)[i]; });
  columns.emplace_back("predicted", unit, &Summary::predicted);
  columns.emplace_back("noise_sd", unit, &Summary::sd);
  if (std::ranges::none_of(solution.segments, [](const auto& s) { return std::isnan(s.measured); })) {
    columns.emplace_back("measured", unit, &Summary::measured);
    columns.emplace_back("residual", unit, [](const Summary& s) { return s.measured - s.predicted; });
  }
  return tabulate("positions", "input, prediction and measurement of each segment (means over the samples used)",
                  solution.segments, columns);
}

Estimate answer_of(const Solution& solution, const std::string& channel_unit, const std::vector<std::string>& axes,
                   const std::string& rate_unit) {
  Estimate estimate = estimate_of(solution);
  estimate.tables.push_back(positions(solution, channel_unit, axes, rate_unit));
  OutputModel model = output_model(estimate, solution.output.role, solution.output.shows, channel_unit,
                                   {solution.columns, solution.least, solution.greatest});
  model.recorded = solution.output.recorded;
  model.nominal = solution.output.nominal;
  if (model.terms.size() == estimate.parameters.size()) estimate.models = {std::move(model)};
  warn_of_misfit(solution, channel_unit, estimate.findings);
  return estimate;
}

}  // namespace tumble::linear
