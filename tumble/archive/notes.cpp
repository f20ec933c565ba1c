#include "tumble/archive/notes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/archive/deposits/parts.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/core/instant.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/text_parts.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {

namespace {

using database::Row;

constexpr std::int64_t nanoseconds = 1'000'000'000;

/// The chain of a unit, an instrument or a model of this name. Throws Error::bad_input.
std::string chain_about(const Archive& archive, const std::string& about) {
  auto& database = schema::opened(archive).database;
  std::vector<std::string> chains, known;
  database.visit("SELECT id, name FROM equipment", {}, [&](const Row& row) {
    known.push_back(database::text(row, 0));
    known.push_back(database::text(row, 1));
    if (about == database::text(row, 0) || about == database::text(row, 1))
      chains.push_back(schema::chain_of_equipment(database::text(row, 0)));
  });
  database.visit("SELECT DISTINCT model FROM units", {}, [&](const Row& row) {
    known.push_back(database::text(row, 0));
    if (about == database::text(row, 0)) chains.push_back(schema::chain_of_model(about));
  });
  try {
    const UnitName unit = find_unit(archive, about);
    chains.push_back(schema::chain_of_unit(unit.model, unit.serial));
  } catch (const Error&) {
    if (chains.empty() && known.empty()) throw;
  }
  if (chains.empty())
    throw Error(Error::Kind::bad_input,
                say("the archive has no unit, instrument or model '{}'{}", about, did_you_mean(about, known)));
  if (chains.size() > 1)
    throw Error(Error::Kind::bad_input, say("'{}' means several things: {}; write MODEL/SERIAL or NAME/SERIAL", about,
                                            fmt::join(chains, ", ")));
  return chains.front();
}

Problems problems_of(const ArchiveNote& note, const ArchiveAct& act) {
  Problems problems;
  const auto& kinds = note_kinds();
  if (std::ranges::find(kinds, note.kind) == kinds.end())
    problems.push_back(say("--kind {}: one of {} is expected{}", Name{note.kind}, fmt::join(kinds, ", "),
                           did_you_mean(note.kind, kinds)));
  if (act.who.empty()) problems.emplace_back("--by NAME is missing: an archive keeps who did what");
  if (!note.when.empty() && !parse_iso_time(note.when))
    problems.push_back(say("--ended {}: a time is expected, such as 2026-11-20T09:00:00Z", Name{note.when}));
  if (note.kind == "interval") try {
      if (!(parse_si(note.text, Unit::parse("s")) > 0.0))
        problems.push_back(say("--text {}: an interval is longer than zero", Name{note.text}));
    } catch (const Error& error) {
      problems.push_back(
          say("--text {}: an interval is a time, such as \"365 day\" ({})", Name{note.text}, error.problems.front()));
    }
  return problems;
}

/// The last event of these kinds of each chain.
std::map<std::string, std::string> last_of_chains(database::Database& database, const std::string& kind,
                                                  const std::string& other, bool text) {
  std::map<std::string, std::string> last;
  database.visit(
      "SELECT chain, action, subject FROM events WHERE action = ? OR action = ? ORDER BY chain, seq", {kind, other},
      [&](const Row& row) { last[database::text(row, 0)] = text ? database::text(row, 2) : database::text(row, 1); });
  return last;
}

}  // namespace

const std::vector<std::string>& note_kinds() {
  static const std::vector<std::string> kinds{"adjusted", "damaged",  "interval", "maintained", "modified",
                                              "moved",    "repaired", "remark",   "retired",    "returned"};
  return kinds;
}

void put_note(Archive& archive, const ArchiveNote& note, const ArchiveAct& act) {
  if (auto problems = problems_of(note, act); !problems.empty()) throw Error(Error::Kind::bad_input, problems);
  schema::guarded(archive.address(), [&] {
    const std::string chain = chain_about(archive, note.about);
    const auto when = parse_iso_time(note.when.empty() ? act.when : note.when);
    const std::string happened = iso_second(when.value_or(0));
    auto& database = schema::opened(archive).database;
    database.transact([&] {
      schema::Change change(database, act.who, act.when);
      change.append(chain, {note.kind, note.text, act.why, happened});
    });
  });
}

void withdraw_result(Archive& archive, const std::string& sha256, const ArchiveAct& act) {
  Problems problems;
  if (act.who.empty()) problems.emplace_back("--by NAME is missing: an archive keeps who did what");
  if (act.why.empty()) problems.emplace_back("a result is withdrawn for a reason: --reason TEXT");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  schema::guarded(archive.address(), [&] {
    auto& database = schema::opened(archive).database;
    const std::int64_t id = schema::number_of(sha256);
    database.transact([&] {
      if (!database.ask("SELECT 1 FROM corrections WHERE result = ?", {id}).empty())
        throw Error(Error::Kind::bad_input,
                    say("the result {} was replaced or withdrawn already", Name{first_digits(sha256)}));
      const auto unit =
          database.ask("SELECT u.model, u.serial FROM results r JOIN units u ON u.id = r.unit WHERE r.id = ?", {id});
      if (unit.empty())
        throw Error(Error::Kind::bad_input, say("the archive has no result '{}'", first_digits(sha256)));
      schema::Change change(database, act.who, act.when);
      change.append(schema::chain_of_unit(database::text(unit[0], 0), database::text(unit[0], 1)),
                    {"correction", sha256, act.why, {}},
                    {{&schema::corrections, {{id, database::Value(), act.why, act.who, act.when}}}});
    });
  });
}

std::vector<DueUnit> due_units(const Archive& archive, const std::string& until) {
  return schema::guarded(archive.address(), [&] {
    auto& database = schema::opened(archive).database;
    const auto intervals = last_of_chains(database, "interval", "interval", true);
    const auto service = last_of_chains(database, "retired", "returned", false);
    std::vector<DueUnit> due;
    if (intervals.empty()) return due;
    database.visit(
        "SELECT u.model, u.serial, MAX(r.moment) FROM units u JOIN results r ON r.unit = u.id LEFT JOIN corrections c "
        "ON c.result = r.id WHERE c.result IS NULL GROUP BY u.model, u.serial",
        {}, [&](const Row& row) {
          const UnitName unit{database::text(row, 0), database::text(row, 1)};
          const std::string chain = schema::chain_of_unit(unit.model, unit.serial);
          auto interval = intervals.find(chain);
          if (interval == intervals.end()) interval = intervals.find(schema::chain_of_model(unit.model));
          const auto out = service.find(chain);
          if (interval == intervals.end() || (out != service.end() && out->second == "retired")) return;
          const std::int64_t last = database::integer(row, 2);
          const double length = parse_si(interval->second, Unit::parse("s"));
          const auto day = [](std::int64_t moment) { return iso_day(moment * nanoseconds); };
          const DueUnit one{unit, day(last), day(last + static_cast<std::int64_t>(length))};
          if (one.due <= until) due.push_back(one);
        });
    std::ranges::stable_sort(due, {}, &DueUnit::due);
    return due;
  });
}

}  // namespace tumble
