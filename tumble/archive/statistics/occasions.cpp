#include "tumble/archive/statistics/occasions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "tumble/archive/schema/opened.hpp"
#include "tumble/core/instant.hpp"
#include "tumble/math/square.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::statistics {

namespace {

constexpr double a_day = 24.0 * hour;
constexpr std::size_t no_occasion = std::numeric_limits<std::size_t>::max();

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
  std::vector<std::size_t> last(over.units.size(), no_occasion);
  std::vector<Occasion> occasions;
  std::size_t skipped = 0;
  for (const auto& value : over.values) {
    const auto unit = number.find(value.unit);
    if (!std::isfinite(value.value) || !std::isfinite(value.private_sd) || unit == number.end()) {
      ++skipped;
      continue;
    }
    const auto day = static_cast<std::int64_t>(std::floor(value.moment / a_day));
    std::size_t& open = last[unit->second];
    if (open != no_occasion && occasions[open].day == day && occasions[open].sources == value.sources) {
      take(occasions[open], value);
      continue;
    }
    open = occasions.size();
    occasions.push_back(
        {unit->second, day, value.moment, value.value, value.private_sd, value.sources, value.result, 1});
  }
  if (unused) *unused = skipped;
  return occasions;
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

std::string time_of(double moment) {
  constexpr std::int64_t second = 1'000'000'000;
  return iso_time(static_cast<std::int64_t>(moment) * second).substr(0, 19) + "Z";
}

std::string date_of(std::int64_t day) { return time_of(static_cast<double>(day) * a_day).substr(0, 10); }

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
