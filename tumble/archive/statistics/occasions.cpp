#include "tumble/archive/statistics/occasions.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "tumble/core/instant.hpp"
#include "tumble/math/square.hpp"
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

std::string begin_at_adjustment(PastResults& past) {
  std::unordered_map<std::int64_t, double> begin;
  for (std::size_t i = 0; i < past.adjusted.size(); ++i)
    if (!past.adjusted[i].empty()) begin.emplace(past.over.units[i].first, past.adjusted[i].back());
  double last = -INFINITY;
  std::erase_if(past.over.values, [&](const ChartValue& value) {
    const auto known = begin.find(value.unit);
    if (known == begin.end() || value.moment >= known->second) return false;
    last = std::max(last, known->second);
    return true;
  });
  return std::isfinite(last) ? time_of(last) : std::string();
}

/// The test of the same recordings ended at the same time: only such results are looked at.
void note_same_recordings(const PastResults& past, Findings& findings) {
  std::map<std::pair<std::int64_t, double>, std::vector<std::int64_t>> by_time;
  std::unordered_map<std::int64_t, const ChartValue*> last;
  for (const auto& value : past.over.values) {
    const auto* const before = std::exchange(last[value.unit], &value);
    if (!before || before->moment != value.moment) continue;
    auto& results = by_time[{value.unit, value.moment}];
    if (results.empty()) results.push_back(before->result);
    results.push_back(value.result);
  }
  std::size_t number = 0;
  for (const auto& [when, results] : by_time) {
    std::map<std::string, std::size_t> known;
    for (const auto result : results)
      if (const auto from = past.read.recordings(result); !from.empty() && known[from]++ > 0) ++number;
  }
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

SharedBySource shared_errors(const PastResults& past, const std::vector<Occasion>& occasions) {
  SharedBySource errors;
  for (const auto& occasion : occasions) {
    if (occasion.sources == 0 || errors.contains(occasion.sources)) continue;
    const Estimate estimate = past.read.estimate(occasion.result);
    auto& found = errors[occasion.sources];
    if (const auto* parameter_of = find_parameter(estimate, past.over.parameter))
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

Unit unit_by(const Unit& unit, const std::string& by) {
  return Unit::parse((unit.text() == "1" || unit.text().empty() ? "1" : unit.text()) + "/" + by);
}

}  // namespace tumble::statistics
