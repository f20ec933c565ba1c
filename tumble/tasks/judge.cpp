#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tumble/report/limit_text.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/tasks/plausible.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble {
namespace {

std::optional<Bound> bound_of(const std::optional<Quantity>& written) {
  if (!written) return std::nullopt;
  return Bound{written->unit.to_si(written->value), written->unit};
}

Limit limit_of(const LimitEntry& entry) { return {bound_of(entry.min), bound_of(entry.max)}; }

/// What is wrong with a bound, or empty.
Sentence misfit(const Quantity& bound, const std::string& parameter, const Unit& unit) {
  if (bound.unit.dimension() == unit.dimension()) return {};
  if (bound.bare) return say("{} needs its unit: \"{} {}\"", bound.value, bound.value, Name{unit.text()});
  return say("{} is in {} [{}], not in {} [{}]", Name{parameter}, Name{unit.text()}, Name{name(unit.dimension())},
             Name{bound.unit.text()}, Name{name(bound.unit.dimension())});
}

/// From the interval; NaN bounds of an unknown uncertainty decide nothing.
Verdict judge_one(const Limit& limit, const Estimate& estimate, const Parameter& parameter) {
  const auto index = static_cast<std::size_t>(&parameter - estimate.parameters.data());
  const auto interval = interval95(estimate, index);
  auto outcome = Verdict::Outcome::undecided;
  if (interval.lower >= limit.lowest() && interval.upper <= limit.highest()) outcome = Verdict::Outcome::pass;
  if (interval.upper < limit.lowest() || interval.lower > limit.highest()) outcome = Verdict::Outcome::fail;
  return {parameter.name, outcome, limit};
}

/// A parameter that the data do not show lies between zero and its upper limit.
Verdict judge_hidden(const std::string& parameter, const Limit& limit, const UpperLimit& upper) {
  auto outcome = Verdict::Outcome::undecided;
  if (limit.lowest() <= 0.0 && upper.value <= limit.highest()) outcome = Verdict::Outcome::pass;
  if (upper.value < limit.lowest()) outcome = Verdict::Outcome::fail;
  return {parameter, outcome, limit};
}

/// A limit on a parameter that the result does not have.
Finding without_parameter(const LimitEntry& entry, const std::vector<std::string>& names) {
  const std::string near = nearest(entry.parameter, names);
  return {Finding::Severity::error,
          near.empty() ? "limit_without_parameter" : "limit_near_parameter",
          {{"limit", limit_text(limit_of(entry))},
           {"parameter", entry.parameter},
           {"nearest", near},
           {"parameters", fmt::format("{}", fmt::join(names, ", "))}},
          entry.where};
}

}  // namespace

std::vector<Verdict> judge(const std::vector<LimitEntry>& limits, Estimate& estimate) {
  const Estimate& numbers = judged(estimate);
  std::vector<std::string> names;
  for (const auto& parameter : numbers.parameters) names.push_back(parameter.name);
  std::vector<Verdict> verdicts;
  Problems problems;
  for (const auto& entry : limits) {
    const auto complain = [&](const Sentence& message) {
      problems.push_back(say("{}{}[[limit]]: {}", Name{entry.where}, entry.where.empty() ? "" : ": ", message));
    };
    const Limit limit = limit_of(entry);
    const auto* parameter = find_parameter(numbers, entry.parameter);
    const auto hidden = find_upper_limit(numbers, entry.parameter);
    if (!parameter && !hidden) {
      estimate.findings.push_back(without_parameter(entry, names));
      verdicts.push_back({entry.parameter, Verdict::Outcome::undecided, limit});
      continue;
    }
    const auto before = problems.size();
    for (const auto* bound : {&entry.min, &entry.max})
      if (*bound)
        if (const auto problem = misfit(**bound, entry.parameter, parameter ? parameter->unit : hidden->unit);
            !problem.empty())
          complain(problem);
    if (problems.size() > before) continue;
    verdicts.push_back(parameter ? judge_one(limit, numbers, *parameter)
                                 : judge_hidden(entry.parameter, limit, *hidden));
    if (is_undermined(estimate, entry.parameter)) verdicts.back().outcome = Verdict::Outcome::undecided;
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return verdicts;
}

}  // namespace tumble
