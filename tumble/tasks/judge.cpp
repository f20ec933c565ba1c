#include <fmt/format.h>
#include <fmt/ranges.h>

#include <limits>

#include "tumble/report/rounding.hpp"
#include "tumble/tasks/plausible.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble {
namespace {

std::string written(const Quantity& bound) {
  const auto number = fmt::format("{}", bound.value);
  return bound.bare ? number : number + " " + bound.unit.text();
}

std::string written(const Limit& limit) {
  if (limit.min && limit.max) return fmt::format("{} to {}", written(*limit.min), written(*limit.max));
  return limit.min ? ">= " + written(*limit.min) : "<= " + written(*limit.max);
}

/// What is wrong with a bound, or empty.
std::string misfit(const Quantity& bound, const std::string& parameter, const Unit& unit) {
  if (bound.unit.dimension() == unit.dimension()) return "";
  if (bound.bare) return fmt::format("{} needs its unit: \"{} {}\"", bound.value, bound.value, unit.text());
  return fmt::format("{} is in {} [{}], not in {} [{}]", parameter, unit.text(), name(unit.dimension()),
                     bound.unit.text(), name(bound.unit.dimension()));
}

/// From the interval; NaN bounds of an unknown uncertainty decide nothing.
Verdict judge_one(const Limit& limit, const Estimate& estimate, const Parameter& parameter) {
  const auto index = static_cast<std::size_t>(&parameter - estimate.parameters.data());
  const auto interval = interval95(estimate, index);
  const double infinity = std::numeric_limits<double>::infinity();
  const double lowest = limit.min ? limit.min->unit.to_si(limit.min->value) : -infinity;
  const double highest = limit.max ? limit.max->unit.to_si(limit.max->value) : infinity;
  auto outcome = Verdict::Outcome::undecided;
  if (interval.lower >= lowest && interval.upper <= highest) outcome = Verdict::Outcome::pass;
  if (interval.upper < lowest || interval.lower > highest) outcome = Verdict::Outcome::fail;
  return {parameter.name, outcome, written(limit)};
}

/// A parameter that the data do not show lies between zero and its upper limit.
Verdict judge_hidden(const Limit& limit, const UpperLimit& upper) {
  const auto bound = [&](const std::optional<Quantity>& one) { return one->unit.to_si(one->value); };
  auto outcome = Verdict::Outcome::undecided;
  if ((!limit.min || bound(limit.min) <= 0.0) && (!limit.max || upper.value <= bound(limit.max)))
    outcome = Verdict::Outcome::pass;
  if (limit.min && upper.value < bound(limit.min)) outcome = Verdict::Outcome::fail;
  return {limit.parameter, outcome, written(limit)};
}

}  // namespace

std::vector<Verdict> judge(const std::vector<Limit>& limits, const Estimate& estimate, Findings& findings) {
  std::vector<std::string> names;
  for (const auto& parameter : estimate.parameters) names.push_back(parameter.name);
  const Findings about_answer = findings;  // what is found below is about a limit
  std::vector<Verdict> verdicts;
  Problems problems;
  for (const auto& limit : limits) {
    const auto complain = [&](const Sentence& message) {
      problems.push_back(say("{}{}[[limit]]: {}", Name{limit.where}, limit.where.empty() ? "" : ": ", message));
    };
    const auto* parameter = find_parameter(estimate, limit.parameter);
    const auto hidden = find_upper_limit(estimate, limit.parameter);
    if (!parameter && !hidden) {
      const std::string near = nearest(limit.parameter, names);
      findings.push_back({Finding::Severity::error,
                          near.empty() ? "limit_without_parameter" : "limit_near_parameter",
                          {{"limit", written(limit)},
                           {"parameter", limit.parameter},
                           {"nearest", near},
                           {"parameters", fmt::format("{}", fmt::join(names, ", "))}},
                          limit.where});
      verdicts.push_back({limit.parameter, Verdict::Outcome::undecided, written(limit)});
      continue;
    }
    const auto before = problems.size();
    for (const auto* bound : {&limit.min, &limit.max})
      if (*bound)
        if (const auto problem = misfit(**bound, limit.parameter, parameter ? parameter->unit : hidden->unit);
            !problem.empty())
          complain(problem);
    if (problems.size() > before) continue;
    verdicts.push_back(parameter ? judge_one(limit, estimate, *parameter) : judge_hidden(limit, *hidden));
    if (is_undermined(limit.parameter, estimate.parameters, about_answer))
      verdicts.back().outcome = Verdict::Outcome::undecided;
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return verdicts;
}

}  // namespace tumble
