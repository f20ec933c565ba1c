#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/archive/statistics/answer.hpp"
#include "tumble/archive/statistics/fleet.hpp"
#include "tumble/core/columns.hpp"
#include "tumble/core/instant.hpp"
#include "tumble/exchange/comparison.hpp"
#include "tumble/math/square.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

namespace {

using namespace statistics;
using Severity = Finding::Severity;

constexpr double one_day = 24.0 * hour, one_month = 365.25 * one_day / 12.0;

/// The results of one unit since it was last adjusted.
struct UnitPast {
  PastResults all;
  std::vector<Occasion> occasions;
  std::vector<ArchivedResult> results;  ///< that count and have the parameter
  std::vector<NamedResult> estimates;   ///< the same
  double origin = 0.0;                  ///< [s] since 1970: the adjustment, or the first result
  std::string adjusted;                 ///< when, UTC; empty: never
};

std::string last_adjustment(const UnitRecord& record) {
  std::string last;
  for (const auto& step : record.steps)
    if (step.action == "adjusted" && step.detail > last) last = step.detail;
  return last;
}

UnitPast past_of(const Archive& archive, const DriftRequest& request) {
  UnitPast past{.all = past_results(archive, request.what.parameter, {}, request.what.unit, false),
                .occasions = {},
                .results = {},
                .estimates = {},
                .adjusted = {}};
  const auto record = unit_record(archive, request.what.unit);
  past.adjusted = last_adjustment(record);
  const double begin = past.adjusted.empty() ? -INFINITY : moment_of_text(past.adjusted);
  std::erase_if(past.all.over.values, [&](const ChartValue& value) { return value.moment < begin; });
  past.occasions = occasions_of(past.all.over);
  for (const auto& result : record.results) {
    if (!result.correction.empty() || moment_of_text(result.ended.empty() ? result.archived : result.ended) < begin)
      continue;
    auto estimate = estimate_from_json(result_text(archive, result.sha256), "result " + first_digits(result.sha256));
    if (!find_parameter(estimate, request.what.parameter)) continue;
    past.results.push_back(result);
    past.estimates.push_back({first_digits(result.sha256), std::move(estimate)});
  }
  if (past.occasions.empty())
    throw Error(Error::Kind::bad_input,
                say("{} has no result with the parameter '{}' since it was adjusted ({})",
                    Name{name_of(request.what.unit)}, request.what.parameter, Name{past.adjusted}));
  past.origin = past.adjusted.empty() ? past.occasions.front().moment : begin;
  return past;
}

/// [1] E_n of the parameter between two results; NaN where it cannot be said.
double e_n_between(const UnitPast& past, std::size_t earlier, std::size_t later, const std::string& parameter) {
  const auto comparison = compare({past.estimates[earlier], past.estimates[later]});
  for (const auto& one : comparison.pairs.front().differences)
    if (one.parameter == parameter) return one.e_n;
  return std::nan("");
}

Table history_table(const UnitPast& past, const std::string& parameter) {
  const Unit& unit = past.all.over.shown;
  const auto estimate = [&](std::size_t i) -> const Estimate& { return past.estimates[i].estimate; };
  const auto time = [&](std::size_t i) {
    return past.results[i].ended.empty() ? past.results[i].archived : past.results[i].ended;
  };
  const auto sd = [&](std::size_t i) {
    const auto* found = find_parameter(estimate(i), parameter);
    return standard_uncertainty(estimate(i), static_cast<std::size_t>(found - estimate(i).parameters.data()));
  };
  const auto to_previous = [&](std::size_t i) { return i > 0 ? e_n_between(past, i - 1, i, parameter) : std::nan(""); };
  const auto to_first = [&](std::size_t i) { return i > 0 ? e_n_between(past, 0, i, parameter) : std::nan(""); };
  return tabulate("history", "results in order of time; E_n beyond 1 is a change that the uncertainties do not explain",
                  past.results.size(),
                  {{"time", time},
                   {"value", unit, [&](std::size_t i) { return find_parameter(estimate(i), parameter)->value; }},
                   {"sd", unit, sd},
                   {"E_n to previous", to_previous},
                   {"E_n to first", to_first},
                   {"by", [&](std::size_t i) { return past.results[i].who; }},
                   {"result", [&](std::size_t i) { return first_digits(past.results[i].sha256); }}});
}

/// A number over the random walks that are possible, each with its weight.
struct Averaged {
  double mean = 0.0, variance = 0.0;
};
template <typename AtWalk>
Averaged averaged(const WalkDensity& walks, const AtWalk& at_walk) {
  const double least = 1e-6 * std::ranges::max(walks.weight);
  double sum = 0.0, first = 0.0, second = 0.0;
  for (std::size_t i = 0; i < walks.walk.size(); ++i) {
    if (walks.weight[i] < least) continue;
    const auto [value, variance] = at_walk(walks.walk[i]);
    sum += walks.weight[i];
    first += walks.weight[i] * value;
    second += walks.weight[i] * (variance + square(value));
  }
  first /= sum;
  return {first, std::max(0.0, second / sum - square(first))};
}

double walk_quantile(const WalkDensity& walks, double probability) {
  double sum = 0.0;
  for (std::size_t i = 0; i < walks.walk.size(); ++i) {
    sum += walks.weight[i];
    if (sum >= probability) return walks.walk[i];
  }
  return walks.walk.back();
}

std::vector<Stated> drift_numbers(const UnitPast& past, const UnitHistory& history, const FleetDrift& fleet) {
  const std::string& name = past.all.over.parameter;
  const Unit rate = unit_by(past.all.over.shown, "day"), walk = unit_by(past.all.over.shown, "sqrt(day)");
  const auto trend = averaged(fleet.walks, [&](double q) {
    const auto at = drift_rate(history, q);
    return Averaged{at.value, square(at.sd)};
  });
  const auto q = averaged(fleet.walks, [](double value) { return Averaged{value, 0.0}; });
  return {{name + "_drift_rate", "trend of this unit", rate, trend.mean, std::sqrt(trend.variance), std::nan(""),
           std::nan("")},
          {name + "_random_walk", "random walk of the units of the model", walk, q.mean, std::sqrt(q.variance),
           walk_quantile(fleet.walks, 0.025), walk_quantile(fleet.walks, 0.975)}};
}

/// [s] Offered: whole months, and never more than twice the longest interval between days that were seen.
double offered_interval(const UnitPast& past, double interval) {
  double longest = 0.0;
  for (std::size_t i = 1; i < past.occasions.size(); ++i)
    longest = std::max(longest, past.occasions[i].moment - past.occasions[i - 1].moment);
  return std::floor(std::min(interval, 2.0 * longest) / one_month) * one_month;
}

Table recalibration_table(const UnitPast& past, const RecalibrationInterval& found, double risk) {
  using Interval = RecalibrationInterval;
  const double last = past.occasions.back().moment, offered = offered_interval(past, found.interval);
  return tabulate(
      "recalibration",
      fmt::format("time after the last result until the true value is outside the limits with a probability "
                  "of {:g} %; shortest and longest for the 95 % and 5 % points of the random walk; offered: "
                  "whole months, at most twice the longest interval seen",
                  100.0 * risk),
      std::vector{found},
      {{"interval", "day", &Interval::interval},
       {"shortest", "day", &Interval::shortest},
       {"longest", "day", &Interval::longest},
       {"offered", "day", [&](const Interval&) { return offered; }},
       {"due", [&](const Interval&) { return day_of(last + offered); }}});
}

std::vector<Curve> drift_curves(const UnitPast& past, const UnitHistory* history, const FleetDrift& fleet,
                                const DriftRequest& request, std::vector<Link>& links) {
  constexpr double normal_90 = 1.645;  // two-sided
  constexpr int steps = 40;
  const Unit& unit = past.all.over.shown;
  const std::string& name = past.all.over.parameter;
  const std::int64_t day = past.occasions.front().day;
  Curve values = curve_over_time("result of a day", "history", day, name, unit);
  values.points = true, values.band = "± 2 sd, private part";
  for (const auto& one : past.occasions) {
    add_point(values, since(day, one.moment), one.value, 2.0 * one.private_sd);
    links.push_back(link_of(values, name_of(request.what.unit), one.result));
  }
  std::vector<Curve> curves{values};
  const double last = past.occasions.back().moment;
  const double end = last + std::max(0.5 * (last - past.occasions.front().moment), 30.0 * one_day);
  if (history) {
    Curve ahead = curve_over_time("forecast of the true value", "history", day, name, unit);
    ahead.band = "90 %";
    for (int i = 0; i <= steps; ++i) {
      const double time = last + (end - last) * i / steps;
      const auto at = averaged(fleet.walks, [&](double q) {
        const auto one = forecast(*history, q, time - past.origin);
        return Averaged{one.value, one.variance};
      });
      add_point(ahead, since(day, time), at.mean, normal_90 * std::sqrt(at.variance));
    }
    curves.push_back(ahead);
  }
  for (const double limit : {request.limits.lower, request.limits.upper}) {
    if (!std::isfinite(limit)) continue;
    Curve line =
        curve_over_time(limit == request.limits.lower ? "lower limit" : "upper limit", "history", day, name, unit);
    add_point(line, since(day, past.occasions.front().moment), limit);
    add_point(line, since(day, end), limit);
    curves.push_back(line);
  }
  return curves;
}

void drift_findings(const UnitPast& past, const FleetDrift& fleet, Findings& findings) {
  constexpr std::size_t few = 10;
  if (!past.adjusted.empty())
    findings.push_back({Severity::info, "history_since_adjustment", {{"time", past.adjusted}}});
  if (fleet.units < few) findings.push_back({Severity::info, "drift_of_few_units", {{"units", fleet.units}}});
  if (!fleet.day_known) findings.push_back({Severity::info, "drift_day_unknown", {}});
}

/// The fleet of the model, whose random walk counts for its units.
FleetDrift fleet_of(const Archive& archive, const ArchivedSelection& what, SharedBySource& errors) {
  const PastResults past = past_results(archive, what.parameter, what.unit.model);
  const auto occasions = occasions_of(past.over);
  errors = shared_errors(past, occasions);
  return drift_of_fleet(occasions, past.adjusted, errors);
}

}  // namespace

Estimate drift_of_unit(const Archive& archive, const DriftRequest& request) {
  const auto& what = request.what;
  Estimate estimate =
      answer_of("archive_drift", fmt::format("History of {} of {}", what.parameter, name_of(what.unit)), what);
  const UnitPast past = past_of(archive, request);
  note_same_recordings(past.all, estimate.findings);
  estimate.tables.push_back(history_table(past, what.parameter));
  state(estimate, {});
  std::vector<Link> links;
  if (past.occasions.size() < 2 || past.occasions.back().moment == past.occasions.front().moment) {
    estimate.findings.push_back({Severity::info, "history_too_short", {}});
    estimate.curves = drift_curves(past, nullptr, {}, request, links);
    estimate.tables.push_back(links_table(links, past.all.over.shown));
    return estimate;
  }
  SharedBySource errors;
  const FleetDrift fleet = fleet_of(archive, what, errors);
  UnitHistory history = history_of(past.occasions, past.origin, fleet.day_sd, errors);
  history.rate = fleet.rate, history.rate_sd = fleet.rate_sd;
  state(estimate, drift_numbers(past, history, fleet));
  estimate.curves = drift_curves(past, &history, fleet, request, links);
  estimate.tables.push_back(links_table(links, past.all.over.shown));
  if (std::isfinite(request.limits.lower) || std::isfinite(request.limits.upper))
    estimate.tables.push_back(
        recalibration_table(past,
                            recalibration_interval(history, fleet.walks, request.limits.lower, request.limits.upper,
                                                   request.risk, request.longest),
                            request.risk));
  drift_findings(past, fleet, estimate.findings);
  return estimate;
}

}  // namespace tumble
