#include "tumble/archive/past_results.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <unordered_map>
#include <utility>

#include "tumble/archive/deposits/parts.hpp"
#include "tumble/archive/deposits/sources.hpp"
#include "tumble/archive/schema/chain.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/archive/statistics/occasions.hpp"
#include "tumble/archive/statistics/over_units.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/report/report.hpp"

namespace tumble {

namespace {

/// A number as a database keeps it: it has no infinity, and one zero.
double as_kept(double value) { return std::isfinite(value) ? value + 0.0 : std::numeric_limits<double>::quiet_NaN(); }

std::string recordings_of(const Estimate& estimate) {
  std::vector<std::string> recordings;
  for (const auto& [role, sha256, name] : deposits::inputs_of(estimate))
    if (role == "recording") recordings.push_back(sha256);
  std::ranges::sort(recordings);
  std::string text;
  for (const auto& sha256 : recordings) text += estimate.method + " " + sha256 + "\n";
  return text;
}

std::string recordings_of(const Archive& archive, std::int64_t result) {
  return schema::guarded(archive.address(), [&] {
    std::string text;
    schema::opened(archive).database.visit(
        "SELECT r.method, i.sha256 FROM inputs i JOIN results r ON r.id = i.result WHERE i.result = ? AND "
        "i.role = 'recording' ORDER BY i.sha256",
        {result},
        [&](const database::Row& row) { text += database::text(row, 0) + " " + database::text(row, 1) + "\n"; });
    return text;
  });
}

std::string sha256_in(const Archive& archive, std::int64_t result) {
  return schema::guarded(archive.address(), [&] {
    const auto rows = schema::opened(archive).database.ask("SELECT sha256 FROM results WHERE id = ?", {result});
    return rows.empty() ? std::string() : database::text(rows[0], 0);
  });
}

/// [s] since 1970, in order: when each unit was adjusted.
std::vector<std::vector<double>> adjustments_of(const Archive& archive, const ParameterOverUnits& over) {
  std::unordered_map<std::string, std::size_t> unit_of;
  for (std::size_t i = 0; i < over.units.size(); ++i)
    unit_of.emplace(schema::chain_of_unit(over.units[i].second.model, over.units[i].second.serial), i);
  std::vector<std::vector<double>> adjustments(over.units.size());
  const auto take_event = [&](const database::Row& row) {
    if (const auto unit = unit_of.find(database::text(row, 0)); unit != unit_of.end())
      adjustments[unit->second].push_back(statistics::moment_of_text(database::text(row, 1)));
  };
  schema::guarded(archive.address(), [&] {
    auto& database = schema::opened(archive).database;
    const std::string adjusted = "SELECT chain, detail FROM events WHERE action = 'adjusted'";
    if (over.units.size() == 1)
      database.visit(adjusted + " AND chain = ?", {unit_of.begin()->first}, take_event);
    else
      database.visit(adjusted, {}, take_event);
  });
  for (auto& times : adjustments) std::ranges::sort(times);
  return adjustments;
}

/// The units of a model, in order of their numbers in an archive.
std::vector<std::pair<std::int64_t, UnitName>> units_of(const std::vector<SummarisedResult>& results,
                                                        const std::string& model) {
  std::map<std::int64_t, UnitName> units;
  for (const auto& result : results)
    if (result.unit.model == model)
      units.emplace(schema::number_of(deposits::sha256_of_unit(result.unit)), result.unit);
  return {units.begin(), units.end()};
}

void take_values(const std::vector<SummarisedResult>& results, const std::string& model, ParameterOverUnits& over) {
  for (const auto& result : results) {
    if (result.unit.model != model) continue;
    const std::int64_t unit = schema::number_of(deposits::sha256_of_unit(result.unit));
    for (const auto& one : result.values)
      if (one.parameter == over.parameter)
        over.values.push_back({unit, result.number, result.moment, one.value, one.sd, one.private_sd, one.sources});
  }
  std::ranges::sort(over.values, {}, [](const ChartValue& one) { return std::pair(one.moment, one.result); });
}

using ByNumber = std::unordered_map<std::int64_t, const SummarisedResult*>;

Unit shown_unit_of(const ParameterOverUnits& over, const ByNumber& results) {
  std::map<std::string, std::int64_t> shown;
  for (const auto number : statistics::compared_results(over))
    for (const auto& value : results.at(number)->values) {
      if (value.parameter != over.parameter) continue;
      auto& smallest = shown.emplace(value.shown, number).first->second;
      smallest = std::min(smallest, number);
    }
  return statistics::shown_unit(over, shown);
}

}  // namespace

SummarisedResult summary_of_result(const ResultDeposit& deposit, const std::string& undated, Problems& problems) {
  const deposits::ReadResult result = deposits::read_result(deposit, problems);
  SummarisedResult summary{
      .file = deposit.file, .sha256 = result.sha256, .unit = result.unit, .recordings = {}, .values = {}};
  if (result.sha256.empty()) return summary;  // its text is no result
  const Estimate& estimate = result.estimate;
  summary.number = schema::number_of(result.sha256);
  summary.moment = static_cast<double>(deposits::moment_of(result.ended, undated));
  summary.recordings = recordings_of(estimate);
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const auto [private_sd, sources] = deposits::sources_of(estimate, i);
    const Parameter& parameter = estimate.parameters[i];
    summary.values.push_back({parameter.name, parameter.unit.text(), as_kept(parameter.value),
                              as_kept(standard_uncertainty(estimate, i)), as_kept(private_sd), sources});
  }
  return summary;
}

PastResults past_results(const std::vector<SummarisedResult>& results, const std::string& parameter,
                         const std::string& model) {
  const auto by_number = std::make_shared<ByNumber>();
  for (const auto& result : results) by_number->emplace(result.number, &result);
  PastResults past;
  past.over.parameter = parameter;
  past.over.units = units_of(results, model);
  take_values(results, model, past.over);
  statistics::require_values(past.over, model, {});
  past.over.shown = shown_unit_of(past.over, *by_number);
  past.read = {.estimate =
                   [by_number](std::int64_t result) {
                     const SummarisedResult& one = *by_number->at(result);
                     return estimate_from_json(read_text_file(one.file), "result " + one.sha256);
                   },
               .sha256 = [by_number](std::int64_t result) { return by_number->at(result)->sha256; },
               .recordings = [by_number](std::int64_t result) { return by_number->at(result)->recordings; }};
  return past;
}

PastResults past_results(const Archive& archive, const std::string& parameter, const std::string& model,
                         const UnitName& unit, bool with_adjustments) {
  PastResults past;
  past.over = parameter_over_units(archive, parameter, model, unit);
  if (with_adjustments) past.adjusted = adjustments_of(archive, past.over);
  past.read = {.estimate =
                   [&archive](std::int64_t result) {
                     const std::string sha256 = sha256_in(archive, result);
                     return estimate_from_json(result_text(archive, sha256), "result " + sha256);
                   },
               .sha256 = [&archive](std::int64_t result) { return sha256_in(archive, result); },
               .recordings = [&archive](std::int64_t result) { return recordings_of(archive, result); }};
  return past;
}

}  // namespace tumble
