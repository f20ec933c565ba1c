#include "tumble/archive/history.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "tumble/archive/deposits/parts.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/archive/signatures.hpp"
#include "tumble/archive/storage/packing.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

namespace {

using database::integer;
using database::number;
using database::Row;
using database::text;

database::Database& database_of(const Archive& archive) { return schema::opened(archive).database; }

std::vector<ArchivedResult> results_of(database::Database& database, const UnitName& unit, std::int64_t id) {
  std::vector<ArchivedResult> results;
  database.visit(
      "SELECT r.sha256, r.run, r.method, r.title, r.program_version, r.verdict, r.who, r.begun, r.ended, r.archived, "
      "r.seed, "
      "n.sha256, c.reason FROM results r LEFT JOIN corrections c ON c.result = r.id LEFT JOIN results n ON n.id = "
      "c.replaced_by WHERE r.unit = ? ORDER BY r.moment, r.id",
      {id}, [&](const Row& row) {
        results.push_back({.sha256 = text(row, 0),
                           .unit = unit,
                           .run = text(row, 1),
                           .method = text(row, 2),
                           .title = text(row, 3),
                           .program_version = text(row, 4),
                           .verdict = text(row, 5),
                           .who = text(row, 6),
                           .begun = text(row, 7),
                           .ended = text(row, 8),
                           .archived = text(row, 9),
                           .simulated = !text(row, 10).empty(),
                           .replaced_by = text(row, 11),
                           .correction = text(row, 12)});
      });
  return results;
}

void files_and_certificates(database::Database& database, std::int64_t id, UnitRecord& record) {
  database.visit(
      "SELECT DISTINCT f.sha256, f.role, f.name, f.run, f.slot, f.bytes FROM files f WHERE f.unit = ? OR f.sha256 IN "
      "(SELECT i.sha256 FROM inputs i JOIN results r ON r.id = i.result WHERE r.unit = ?) ORDER BY 2, 3, 1",
      {id, id}, [&](const Row& row) {
        record.files.push_back({text(row, 0), text(row, 1), text(row, 2), text(row, 3), text(row, 4), integer(row, 5)});
      });
  database.visit(
      "SELECT c.sha256, c.number, r.sha256, c.format, c.issued_by, c.issued FROM certificates c JOIN results r ON r.id "
      "= "
      "c.result WHERE r.unit = ? ORDER BY c.issued, c.number, c.format",
      {id}, [&](const Row& row) {
        record.certificates.push_back(
            {text(row, 0), text(row, 1), text(row, 2), text(row, 3), text(row, 4), text(row, 5)});
      });
}

std::vector<ArchivedStep> steps_of(database::Database& database, const std::string& chain) {
  std::vector<ArchivedStep> steps;
  database.visit("SELECT seq, time, who, action, subject, reason, detail FROM events WHERE chain = ? ORDER BY seq",
                 {chain}, [&](const Row& row) {
                   steps.push_back({integer(row, 0), text(row, 1), text(row, 2), text(row, 3), text(row, 4),
                                    text(row, 5), text(row, 6)});
                 });
  return steps;
}

void runs_and_steps(database::Database& database, std::int64_t id, UnitRecord& record) {
  database.visit(
      "SELECT r.id, r.title, r.station, r.operator, r.started, r.ended, r.ending, s.slot FROM runs r JOIN run_units s "
      "ON "
      "s.run = r.id WHERE s.unit = ? ORDER BY r.started, r.id",
      {id}, [&](const Row& row) {
        record.runs.push_back({text(row, 0), text(row, 1), text(row, 2), text(row, 3), text(row, 4), text(row, 5),
                               text(row, 6), text(row, 7)});
      });
  record.steps = steps_of(database, schema::chain_of_unit(record.name.model, record.name.serial));
}

[[noreturn]] void refuse_unit(database::Database& database, const std::string& words) {
  std::vector<std::string> known;
  database.visit("SELECT serial, model FROM units", {}, [&](const Row& row) {
    known.push_back(text(row, 0));
    known.push_back(text(row, 1) + "/" + text(row, 0));
  });
  throw Error(Error::Kind::bad_input, say("the archive has no unit '{}'{}", words, did_you_mean(words, known)));
}

constexpr std::size_t fewest_digits = 6;

void require_digits(const std::string& digits) {
  const bool hex = is_hex(digits);
  if (digits.size() < fewest_digits || !hex)
    throw Error(Error::Kind::bad_input,
                say("'{}' names no result: give the first digits of its SHA-256, {} or more, as `tumble archive "
                    "history` shows them",
                    digits, fewest_digits));
}

/// The SHA-256 (of runs the id) that begins so, in this table. Throws Error::bad_input for several.
std::vector<std::string> beginning_with(database::Database& database, const std::string& table,
                                        const std::string& digits, const std::string& column = "sha256") {
  std::vector<std::string> found;
  database.visit(fmt::format("SELECT {0} FROM {1} WHERE {0} >= ? AND {0} < ? ORDER BY {0} LIMIT 2", column, table),
                 {digits, digits + "g"}, [&](const Row& row) { found.push_back(text(row, 0)); });
  if (found.size() > 1)
    throw Error(Error::Kind::bad_input, say("several {} begin with '{}': give more digits", table.c_str(), digits));
  return found;
}

}  // namespace

std::vector<ArchivedUnit> archived_units(const Archive& archive, const std::string& model) {
  return schema::guarded(archive.address(), [&] {
    std::vector<ArchivedUnit> units;
    database_of(archive).visit(
        "SELECT u.model, u.serial, COUNT(r.id), MIN(COALESCE(r.ended, r.archived)), MAX(COALESCE(r.ended, r.archived)) "
        "FROM "
        "units u LEFT JOIN results r ON r.unit = u.id WHERE (? = '' OR u.model = ?) GROUP BY u.model, u.serial",
        {model, model}, [&](const Row& row) {
          units.push_back(
              {{text(row, 0), text(row, 1)}, static_cast<std::size_t>(integer(row, 2)), text(row, 3), text(row, 4)});
        });
    std::ranges::sort(units, {}, [](const ArchivedUnit& unit) { return std::tie(unit.name.model, unit.name.serial); });
    return units;
  });
}

UnitName find_unit(const Archive& archive, const std::string& words) {
  return schema::guarded(archive.address(), [&] {
    auto& database = database_of(archive);
    std::vector<UnitName> found;
    std::vector<std::string> names;
    const auto look = [&](const std::string& model, const std::string& serial) {
      database.visit("SELECT model, serial FROM units WHERE serial = ? AND (? = '' OR model = ?) ORDER BY model",
                     {serial, model, model}, [&](const Row& row) {
                       found.push_back({text(row, 0), text(row, 1)});
                       names.push_back(text(row, 0) + "/" + text(row, 1));
                     });
    };
    look("", words);
    const bool by_serial = !found.empty();
    for (auto slash = words.find('/'); !by_serial && slash != std::string::npos; slash = words.find('/', slash + 1))
      look(words.substr(0, slash), words.substr(slash + 1));
    if (found.empty()) refuse_unit(database, words);
    if (found.size() > 1)
      throw Error(Error::Kind::bad_input,
                  say("several models have the serial number '{}': write one of {}", words, fmt::join(names, ", ")));
    return found.front();
  });
}

UnitRecord unit_record(const Archive& archive, const UnitName& unit) {
  return schema::guarded(archive.address(), [&] {
    auto& database = database_of(archive);
    const std::int64_t id = schema::number_of(deposits::sha256_of_unit(unit));
    UnitRecord record;
    record.name = unit;
    record.results = results_of(database, unit, id);
    files_and_certificates(database, id, record);
    runs_and_steps(database, id, record);
    record.signatures = signatures_of(archive, unit);
    return record;
  });
}

std::vector<std::string> charted_parameters(const Archive& archive, const std::string& model, const UnitName& unit) {
  return schema::guarded(archive.address(), [&] {
    auto& database = database_of(archive);
    std::vector<std::string> names;
    const bool one = !unit.serial.empty();
    const auto results = database.ask(
        one ? "SELECT r.id FROM results r WHERE r.unit = ? ORDER BY r.moment DESC LIMIT 50"
            : "SELECT r.id FROM results r JOIN units u ON u.id = r.unit WHERE u.model = ? ORDER BY r.moment DESC LIMIT "
              "50",
        {one ? database::Value(schema::number_of(deposits::sha256_of_unit(unit))) : database::Value(model)});
    for (const auto& result : results)
      database.visit("SELECT name FROM parameters WHERE result = ? AND value IS NOT NULL ORDER BY place", {result[0]},
                     [&](const Row& row) {
                       if (std::ranges::find(names, text(row, 0)) == names.end()) names.push_back(text(row, 0));
                     });
    return names;
  });
}

std::string find_result(const Archive& archive, const std::string& digits) {
  require_digits(digits);
  return schema::guarded(archive.address(), [&] {
    const auto found = beginning_with(database_of(archive), "results", digits);
    if (found.empty()) throw Error(Error::Kind::bad_input, say("the archive has no result '{}'", digits));
    return found.front();
  });
}

std::map<std::int64_t, std::string> sha256_by_number(const Archive& archive, const std::vector<std::int64_t>& numbers) {
  constexpr std::size_t at_once = 100;
  std::map<std::int64_t, std::string> found;
  return schema::guarded(archive.address(), [&] {
    for (std::size_t first = 0; first < numbers.size(); first += at_once) {
      const std::size_t last = std::min(numbers.size(), first + at_once);
      std::string marks;
      Row values;
      for (std::size_t i = first; i < last; ++i) marks += i == first ? "?" : ", ?", values.push_back(numbers[i]);
      database_of(archive).visit("SELECT id, sha256 FROM results WHERE id IN (" + marks + ")", values,
                                 [&](const Row& row) { found[integer(row, 0)] = text(row, 1); });
    }
    return found;
  });
}

std::string result_text(const Archive& archive, const std::string& sha256) {
  return schema::guarded(archive.address(), [&] {
    const auto rows = database_of(archive).ask("SELECT packed FROM results WHERE id = ?", {schema::number_of(sha256)});
    if (rows.empty()) throw Error(Error::Kind::bad_input, say("the archive has no result '{}'", sha256));
    const Sentence what = say("result {}", Name{first_digits(sha256)});
    std::string json = storage::unpacked(database::bytes(rows[0], 0), what);
    if (sha256_of(json) != sha256)
      throw Error(Error::Kind::bad_file, say("{}: its bytes have changed since it was archived", what));
    return json;
  });
}

std::optional<StoredFile> find_file(const Archive& archive, const std::string& digits) {
  require_digits(digits);
  return schema::guarded(archive.address(), [&]() -> std::optional<StoredFile> {
    auto& database = database_of(archive);
    if (const auto found = beginning_with(database, "files", digits); !found.empty())
      return StoredFile{found.front(),
                        text(database.ask("SELECT name FROM files WHERE sha256 = ?", {found.front()})[0], 0)};
    const auto found = beginning_with(database, "certificates", digits);
    if (found.empty()) return std::nullopt;
    const auto row = database.ask("SELECT number, format FROM certificates WHERE sha256 = ?", {found.front()})[0];
    return StoredFile{found.front(), text(row, 0) + (text(row, 1).starts_with("dcc") ? ".xml" : ".html")};
  });
}

std::optional<RunRecord> find_run(const Archive& archive, const std::string& digits) {
  require_digits(digits);
  return schema::guarded(archive.address(), [&]() -> std::optional<RunRecord> {
    auto& database = database_of(archive);
    const auto found = beginning_with(database, "runs", digits, "id");
    if (found.empty()) return std::nullopt;
    RunRecord record;
    const Row row =
        database.ask("SELECT id, title, station, operator, started, ended, ending FROM runs WHERE id = ?", {found[0]})
            .at(0);
    record.run = {text(row, 0), text(row, 1), text(row, 2), text(row, 3), text(row, 4), text(row, 5), text(row, 6), {}};
    database.visit(
        "SELECT r.slot, u.model, u.serial FROM run_units r JOIN units u ON u.id = r.unit WHERE r.run = ? ORDER BY "
        "r.slot",
        {found[0]}, [&](const Row& one) {
          record.units.push_back({text(one, 0), {text(one, 1), text(one, 2)}});
        });
    database.visit("SELECT equipment, certificate FROM run_equipment WHERE run = ? ORDER BY equipment", {found[0]},
                   [&](const Row& one) { record.equipment.emplace_back(text(one, 0), text(one, 1)); });
    record.steps = steps_of(database, schema::chain_of_run(found[0]));
    return record;
  });
}

void write_stored(const Archive& archive, const std::string& sha256, const std::string& path) {
  schema::guarded(archive.address(), [&] { storage::unpack_to(schema::opened(archive).files(), sha256, path); });
}

std::vector<ArchivedInput> inputs_of_result(const Archive& archive, const std::string& sha256) {
  return schema::guarded(archive.address(), [&] {
    std::vector<ArchivedInput> inputs;
    for (const Row& row : database_of(archive).ask(
             "SELECT role, sha256, name FROM inputs WHERE result = ? ORDER BY place", {schema::number_of(sha256)}))
      inputs.push_back(
          {text(row, 0), text(row, 1), text(row, 2), storage::is_kept(schema::opened(archive).files(), text(row, 1))});
    return inputs;
  });
}

std::vector<DueCalibration> due_calibrations(const Archive& archive, const std::string& until) {
  return schema::guarded(archive.address(), [&] {
    std::map<std::string, DueCalibration> last;
    database_of(archive).visit("SELECT equipment, certificate, laboratory, due FROM calibrations WHERE due IS NOT NULL",
                               {}, [&](const Row& row) {
                                 DueCalibration& one = last[text(row, 0)];
                                 if (text(row, 3) > one.due)
                                   one = {text(row, 0), text(row, 1), text(row, 2), text(row, 3)};
                               });
    std::map<std::string, std::string> service;
    database_of(archive).visit(
        "SELECT chain, action FROM events WHERE action = 'retired' OR action = 'returned' ORDER BY chain, seq", {},
        [&](const Row& row) { service[text(row, 0)] = text(row, 1); });
    std::vector<DueCalibration> due;
    for (const auto& [equipment, one] : last)
      if (one.due <= until && service[schema::chain_of_equipment(equipment)] != "retired") due.push_back(one);
    std::ranges::stable_sort(due, {}, &DueCalibration::due);
    return due;
  });
}

}  // namespace tumble
