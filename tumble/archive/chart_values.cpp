#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <unordered_set>

#include "tumble/archive/deposits/parts.hpp"
#include "tumble/archive/deposits/sources.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/archive/statistics/over_units.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble {

namespace {

using database::Row;

[[noreturn]] void refuse_parameter(database::Database& database, const std::string& parameter) {
  std::vector<std::string> known;
  database.visit("SELECT DISTINCT name FROM parameters", {},
                 [&](const Row& row) { known.push_back(database::text(row, 0)); });
  throw Error(Error::Kind::bad_input,
              say("no result of the archive has the parameter '{}'{}", parameter, did_you_mean(parameter, known)));
}

std::vector<std::pair<std::int64_t, UnitName>> names_of_units(database::Database& database, const std::string& model,
                                                              const UnitName& unit) {
  std::vector<std::pair<std::int64_t, UnitName>> names;
  const bool single = !unit.serial.empty();
  database.visit(
      "SELECT id, model, serial FROM units WHERE (? = '' OR model = ?) AND (? = '' OR serial = ?)",
      {single ? unit.model : model, single ? unit.model : model, unit.serial, unit.serial}, [&](const Row& row) {
        names.emplace_back(database::integer(row, 0), UnitName{database::text(row, 1), database::text(row, 2)});
      });
  std::ranges::sort(names, {}, [](const auto& one) { return one.first; });
  return names;
}

std::unordered_set<std::int64_t> replaced_results(database::Database& database) {
  std::unordered_set<std::int64_t> replaced;
  database.visit("SELECT result FROM corrections", {},
                 [&](const Row& row) { replaced.insert(database::integer(row, 0)); });
  return replaced;
}

/// The unit that people are shown. `name || ''`: the rows are found by their
/// results; by the index of the name each question would read all values of the parameter.
Unit shown_unit(database::Database& database, const ParameterOverUnits& over) {
  constexpr std::size_t together = 500;
  std::string marks = "?";
  for (std::size_t i = 1; i < together; ++i) marks += ", ?";
  const auto results = statistics::compared_results(over);
  std::map<std::string, std::int64_t> shown;
  for (std::size_t begin = 0; begin < results.size(); begin += together) {
    Row values;
    for (std::size_t i = begin; i < begin + together; ++i)
      values.emplace_back(results[std::min(i, results.size() - 1)]);
    values.emplace_back(over.parameter);
    database.visit("SELECT shown_unit, MIN(result) FROM parameters WHERE result IN (" + marks +
                       ") AND name || '' = ? GROUP BY shown_unit",
                   values, [&](const Row& row) { shown.emplace(database::text(row, 0), database::integer(row, 1)); });
  }
  return statistics::shown_unit(over, shown);
}

/// A result of an archive of version 1 says its sources in its text alone.
void complete(const Archive& archive, const std::string& parameter, ChartValue& value) {
  auto& database = schema::opened(archive).database;
  const auto row = database.ask("SELECT sha256 FROM results WHERE id = ?", {value.result}).at(0);
  const Estimate estimate = estimate_from_json(result_text(archive, database::text(row, 0)), database::text(row, 0));
  const auto* found = find_parameter(estimate, parameter);
  if (!found) return;
  const auto [private_sd, sources] =
      deposits::sources_of(estimate, static_cast<std::size_t>(found - estimate.parameters.data()));
  value.private_sd = private_sd, value.sources = sources;
}

void read_values(database::Database& database, const UnitName& unit, bool all_units, ParameterOverUnits& over) {
  std::unordered_set<std::int64_t> wanted;
  if (!all_units)
    for (const auto& [id, name] : over.units) wanted.insert(id);
  const auto replaced = replaced_results(database);
  const auto take = [&](const Row& row) {
    const ChartValue value{
        database::integer(row, 0), database::integer(row, 1), static_cast<double>(database::integer(row, 2)),
        database::number(row, 3),  database::number(row, 4),  database::number(row, 5),
        database::integer(row, 6)};
    if ((all_units || wanted.contains(value.unit)) && !replaced.contains(value.result)) over.values.push_back(value);
  };
  if (unit.serial.empty())
    database.visit("SELECT unit, result, moment, value, sd, private_sd, sources FROM parameters WHERE name = ?",
                   {over.parameter}, take);
  else
    database.visit(
        "SELECT p.unit, p.result, p.moment, p.value, p.sd, p.private_sd, p.sources FROM results r JOIN parameters p ON "
        "p.result = r.id WHERE "
        "r.unit = ? "
        "AND p.name || '' = ?",
        {schema::number_of(deposits::sha256_of_unit(unit)), over.parameter}, take);
  // Not by the database: of 76 ms that PostgreSQL takes for 200 000 rows, their order takes 52. Results of one moment
  // come in the order of their numbers.
  std::ranges::sort(over.values, {}, [](const ChartValue& one) { return std::pair(one.moment, one.result); });
}

}  // namespace

ParameterOverUnits parameter_over_units(const Archive& archive, const std::string& parameter, const std::string& model,
                                        const UnitName& unit) {
  return schema::guarded(archive.address(), [&] {
    auto& database = schema::opened(archive).database;
    if (database.ask("SELECT 1 FROM parameters WHERE name = ? LIMIT 1", {parameter}).empty())
      refuse_parameter(database, parameter);
    ParameterOverUnits over;
    over.parameter = parameter;
    over.units = names_of_units(database, model, unit);
    read_values(database, unit, model.empty() && unit.serial.empty(), over);
    statistics::require_values(over, model, unit);
    for (auto& value : over.values)
      if (std::isnan(value.private_sd) && std::isfinite(value.sd)) complete(archive, parameter, value);
    over.shown = shown_unit(database, over);
    return over;
  });
}

}  // namespace tumble
