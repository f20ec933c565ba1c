#include "tumble/archive/statistics/occasions.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "tumble/archive/schema/chain.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/core/instant.hpp"
#include "tumble/math/square.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::statistics {

namespace {

constexpr double a_day = 24.0 * hour;

/// Takes one more value into the weighted mean. A value without private uncertainty is alone of its kind: plain mean.
void take(Occasion& occasion, const ChartValue& value) {
  const bool weighted = occasion.private_sd > 0.0 && value.private_sd > 0.0;
  const double count = static_cast<double>(occasion.results);
  const double before = weighted ? 1.0 / square(occasion.private_sd) : count;
  const double added = weighted ? 1.0 / square(value.private_sd) : 1.0;
  occasion.value = (before * occasion.value + added * value.value) / (before + added);
  occasion.private_sd = weighted ? 1.0 / std::sqrt(before + added)
                                 : std::hypot(count * occasion.private_sd, value.private_sd) / (count + 1.0);
  occasion.moment = value.moment;
  occasion.result = value.result;
  ++occasion.results;
}

}  // namespace

std::vector<Occasion> occasions_of(const ParameterOverUnits& over, std::size_t* unused) {
  std::unordered_map<std::int64_t, std::size_t> number;
  for (std::size_t i = 0; i < over.units.size(); ++i) number.emplace(over.units[i].first, i);
  std::vector<std::vector<std::size_t>> open(over.units.size());  // of the newest day of each unit
  std::vector<Occasion> occasions;
  std::size_t skipped = 0;
  for (const auto& value : over.values) {
    const auto unit = number.find(value.unit);
    if (!std::isfinite(value.value) || !std::isfinite(value.private_sd) || unit == number.end()) {
      ++skipped;
      continue;
    }
    const auto day = static_cast<std::int64_t>(std::floor(value.moment / a_day));
    auto& of_day = open[unit->second];
    if (!of_day.empty() && occasions[of_day.front()].day != day) of_day.clear();
    const auto same = std::ranges::find(of_day, value.sources, [&](std::size_t i) { return occasions[i].sources; });
    if (same != of_day.end()) {
      take(occasions[*same], value);
      continue;
    }
    of_day.push_back(occasions.size());
    occasions.push_back(
        {unit->second, day, value.moment, value.value, value.private_sd, value.sources, value.result, 1});
  }
  if (unused) *unused = skipped;
  std::ranges::stable_sort(occasions, {}, &Occasion::moment);
  return occasions;
}

Adjustments adjustments_of(const Archive& archive, const ParameterOverUnits& over) {
  std::unordered_map<std::string, std::size_t> unit_of;
  for (std::size_t i = 0; i < over.units.size(); ++i)
    unit_of.emplace(schema::chain_of_unit(over.units[i].second.model, over.units[i].second.serial), i);
  Adjustments adjustments(over.units.size());
  const auto take_event = [&](const database::Row& row) {
    if (const auto unit = unit_of.find(database::text(row, 0)); unit != unit_of.end())
      adjustments[unit->second].push_back(moment_of_text(database::text(row, 1)));
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

std::string begin_at_adjustment(const Archive& archive, ParameterOverUnits& over) {
  const auto adjustments = adjustments_of(archive, over);
  std::unordered_map<std::int64_t, double> begin;
  for (std::size_t i = 0; i < over.units.size(); ++i)
    if (!adjustments[i].empty()) begin.emplace(over.units[i].first, adjustments[i].back());
  double last = -INFINITY;
  std::erase_if(over.values, [&](const ChartValue& value) {
    const auto known = begin.find(value.unit);
    if (known == begin.end() || value.moment >= known->second) return false;
    last = std::max(last, known->second);
    return true;
  });
  return std::isfinite(last) ? time_of(last) : std::string();
}

/// The test of the same recordings ended at the same time: only such results are looked at.
void note_same_recordings(const Archive& archive, const ParameterOverUnits& over, Findings& findings) {
  std::map<std::pair<std::int64_t, double>, std::vector<std::int64_t>> by_time;
  std::unordered_map<std::int64_t, const ChartValue*> last;
  for (const auto& value : over.values) {
    const auto* const before = std::exchange(last[value.unit], &value);
    if (!before || before->moment != value.moment) continue;
    auto& results = by_time[{value.unit, value.moment}];
    if (results.empty()) results.push_back(before->result);
    results.push_back(value.result);
  }
  std::size_t number = 0;
  schema::guarded(archive.address(), [&] {
    auto& database = schema::opened(archive).database;
    for (const auto& [when, results] : by_time) {
      std::map<std::string, std::size_t> known;
      for (const auto result : results) {
        std::string from;
        database.visit(
            "SELECT r.method, i.sha256 FROM inputs i JOIN results r ON r.id = i.result WHERE i.result = ? AND "
            "i.role = 'recording' ORDER BY i.sha256",
            {result},
            [&](const database::Row& row) { from += database::text(row, 0) + " " + database::text(row, 1) + "\n"; });
        if (!from.empty() && known[from]++ > 0) ++number;
      }
    }
  });
  if (number > 0) findings.push_back({Finding::Severity::warning, "archived_twice", {{"results", number}}});
}

std::vector<Occasion> first_of_each_unit(const std::vector<Occasion>& occasions, std::size_t units) {
  std::vector<bool> known(units);
  std::vector<Occasion> first;
  for (const auto& occasion : occasions)
    if (!known[occasion.unit]) {
      known[occasion.unit] = true;
      first.push_back(occasion);
    }
  return first;
}

SharedBySource shared_errors(const Archive& archive, const std::string& parameter,
                             const std::vector<Occasion>& occasions) {
  SharedBySource errors;
  for (const auto& occasion : occasions) {
    if (occasion.sources == 0 || errors.contains(occasion.sources)) continue;
    const std::string sha256 = sha256_of_result(archive, occasion.result);
    const Estimate estimate = estimate_from_json(result_text(archive, sha256), "result " + sha256);
    auto& found = errors[occasion.sources];
    if (const auto* parameter_of = find_parameter(estimate, parameter))
      found = deposits::keyed_errors(estimate, static_cast<std::size_t>(parameter_of - estimate.parameters.data()));
  }
  return errors;
}

Matrix shared_factors(const std::vector<Occasion>& occasions, const SharedBySource& errors) {
  std::map<std::string, std::size_t> column;
  for (const auto& [source, list] : errors)
    for (const auto& error : list) column.emplace(error.name, column.size());
  Matrix factors(occasions.size(), column.size());
  for (std::size_t i = 0; i < occasions.size(); ++i)
    if (const auto known = errors.find(occasions[i].sources); known != errors.end())
      for (const auto& error : known->second) factors(i, column.at(error.name)) = error.factor;
  return factors;
}

double moment_of_text(const std::string& time) {
  constexpr double nanosecond = 1e-9;
  const auto parsed = parse_iso_time(time);
  return parsed ? std::floor(static_cast<double>(*parsed) * nanosecond) : 0.0;
}

std::string time_of(double moment) {
  constexpr std::int64_t second = 1'000'000'000;
  return iso_second(static_cast<std::int64_t>(moment) * second);
}

std::string day_of(double moment) {
  constexpr std::int64_t second = 1'000'000'000;
  return iso_day(static_cast<std::int64_t>(moment) * second);
}

std::string date_of(std::int64_t day) { return day_of(static_cast<double>(day) * a_day); }

std::string name_of(const UnitName& unit) { return unit.model + "/" + unit.serial; }

std::string sha256_of_result(const Archive& archive, std::int64_t result) {
  return schema::guarded(archive.address(), [&] {
    const auto rows = schema::opened(archive).database.ask("SELECT sha256 FROM results WHERE id = ?", {result});
    return rows.empty() ? std::string() : database::text(rows[0], 0);
  });
}

Unit unit_by(const Unit& unit, const std::string& by) {
  return Unit::parse((unit.text() == "1" || unit.text().empty() ? "1" : unit.text()) + "/" + by);
}

}  // namespace tumble::statistics
