#include "tumble/archive/populations.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "tumble/archive/history.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/core/instant.hpp"
#include "tumble/core/tables/document.hpp"
#include "tumble/exchange/populations.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

namespace {

constexpr std::int64_t most_occasions = 2000;

/// A result that was not replaced.
struct Candidate {
  std::string sha256, serial, ended, station;
  std::int64_t moment = 0, parameters = 0;
  bool simulated = false;
};

/// The method of a query, or the only one of the model's results.
std::string method_of(database::Database& database, const PopulationQuery& query) {
  std::vector<std::string> methods, models;
  database.visit("SELECT DISTINCT r.method FROM results r JOIN units u ON u.id = r.unit WHERE u.model = ?",
                 {query.model}, [&](const database::Row& row) { methods.push_back(database::text(row, 0)); });
  std::ranges::sort(methods);
  if (methods.empty()) {
    database.visit("SELECT DISTINCT model FROM units", {},
                   [&](const database::Row& row) { models.push_back(database::text(row, 0)); });
    throw Error(Error::Kind::bad_input,
                say("the archive has no result of the model '{}'{}", query.model, did_you_mean(query.model, models)));
  }
  if (query.method.empty() && methods.size() > 1)
    throw Error(Error::Kind::bad_input, say("the results of the model '{}' are of several methods: --method {}",
                                            query.model, fmt::join(methods, " or --method ")));
  const std::string method = query.method.empty() ? methods.front() : query.method;
  if (std::ranges::find(methods, method) == methods.end())
    throw Error(Error::Kind::bad_input, say("the archive has no result of {} of the model '{}'; it has results of {}",
                                            Name{method}, query.model, fmt::join(methods, ", ")));
  return method;
}

/// Newest first.
std::vector<Candidate> candidates(database::Database& database, const PopulationQuery& query,
                                  const std::string& method) {
  std::map<std::int64_t, std::int64_t> counts;
  database.visit(
      "SELECT p.result, COUNT(*) FROM parameters p JOIN results r ON r.id = p.result JOIN units u ON u.id = r.unit "
      "WHERE u.model = ? AND r.method = ? GROUP BY p.result",
      {query.model, method},
      [&](const database::Row& row) { counts[database::integer(row, 0)] = database::integer(row, 1); });
  std::vector<Candidate> all;
  database.visit(
      "SELECT r.id, r.sha256, u.serial, r.ended, r.moment, r.seed, s.station FROM results r JOIN units u ON u.id = "
      "r.unit "
      "LEFT JOIN corrections c ON c.result = r.id LEFT JOIN runs s ON s.id = r.run WHERE u.model = ? AND r.method = ? "
      "AND c.result IS NULL ORDER BY r.moment DESC, r.id",
      {query.model, method}, [&](const database::Row& row) {
        const Candidate one{database::text(row, 1),         database::text(row, 2),
                            database::text(row, 3),         database::text(row, 6),
                            database::integer(row, 4),      counts[database::integer(row, 0)],
                            !database::text(row, 5).empty()};
        if (one.serial != query.without) all.push_back(one);
      });
  return all;
}

Estimate read(const Archive& archive, const Candidate& one) {
  return estimate_from_json(result_text(archive, one.sha256), "result " + first_digits(one.sha256));
}

/// The rig that carried a test out: its equipment as the plan names it, else the station, else the kind of rig.
std::string rig_of(const Estimate& estimate, const std::string& station) {
  std::string kind;
  if (!estimate.provenance.plans.empty() && estimate.provenance.plans.front().text) {
    const auto& plan = estimate.provenance.plans.front();
    try {
      const auto document = tables::document_of(*plan.text, plan.file);
      const auto set = estimate.provenance.command_line.find("rig.equipment");
      if (set != estimate.provenance.command_line.end()) return set->second;
      if (const auto equipment = document["rig"]["equipment"].value<std::string>()) return *equipment;
      kind = document["rig"]["kind"].value<std::string>().value_or("");
    } catch (const Error&) {  // a plan of another version: its rig is not known
    }
  }
  return station.empty() ? kind : station;
}

/// Results by unit, the units with the newest results first; each unit's in order of preference.
std::vector<std::vector<Candidate>> by_unit(const std::vector<Candidate>& newest_first, std::size_t most) {
  std::map<std::string, std::size_t> place;
  std::vector<std::vector<Candidate>> units;
  for (const auto& one : newest_first) {
    const auto [at, is_new] = place.try_emplace(one.serial, units.size());
    if (is_new) units.emplace_back();
    units[at->second].push_back(one);
  }
  units.resize(std::min(units.size(), most));
  for (auto& results : units)
    std::ranges::stable_sort(results, [](const Candidate& a, const Candidate& b) {
      return a.parameters != b.parameters ? a.parameters > b.parameters : a.moment < b.moment;
    });
  return units;
}

}  // namespace

Estimate population_of(const Archive& archive, const PopulationQuery& query) {
  return schema::guarded(archive.address(), [&] {
    auto& database = schema::opened(archive).database;
    const auto method = method_of(database, query);
    std::vector<TestedUnit> units;
    std::vector<ResultLeftOut> left_out;
    for (const auto& results : by_unit(candidates(database, query, method), query.most))
      for (const auto& one : results) {
        auto estimate = read(archive, one);
        if (const auto why = unfit_for_population(estimate); !why.empty()) {
          left_out.push_back({one.serial, one.sha256, why});
          continue;
        }
        units.push_back({one.serial, one.sha256, one.simulated, std::move(estimate)});
        break;
      }
    return population_of_units(query.model, method, std::move(units), std::move(left_out));
  });
}

Estimate components_of(const Archive& archive, const PopulationQuery& query, const std::string& parameter) {
  return schema::guarded(archive.address(), [&] {
    auto& database = schema::opened(archive).database;
    auto all = candidates(database, query, method_of(database, query));
    all.resize(std::min<std::size_t>(all.size(), most_occasions));
    std::vector<OccasionResult> results;
    std::vector<ResultLeftOut> left_out;
    for (const auto& one : all) {
      auto estimate = read(archive, one);
      if (const auto why = unfit_for_population(estimate); !why.empty()) {
        left_out.push_back({one.serial, one.sha256, why});
        continue;
      }
      const auto rig = rig_of(estimate, one.station);
      const auto ended = parse_iso_time(one.ended);
      results.push_back({one.serial, one.sha256, ended ? iso_day(*ended) : "", rig, static_cast<double>(one.moment),
                         std::move(estimate)});
    }
    return components_of_results(query.model, parameter, std::move(results), std::move(left_out));
  });
}

}  // namespace tumble
