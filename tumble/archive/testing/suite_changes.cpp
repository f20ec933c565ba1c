// What is changed behind the back of an archive is found.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tumble/archive/history.hpp"
#include "tumble/archive/notes.hpp"
#include "tumble/archive/schema/chain.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/archive/testing/suite_helpers.hpp"
#include "tumble/archive/transfer.hpp"
#include "tumble/archive/verify.hpp"
#include "tumble/formats/checksum.hpp"

namespace tumble::testing {

namespace {

/// Rows changed behind the archive's back, one cell of each column after the other, are found.
void changed_cells_are_found(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  put_in(archive, fleet(place), sample_act());
  Deposit correction;
  correction.results.push_back(sample_deposit({.bias = 1.05}));
  correction.results[0].corrects = unit_record(archive, {"gyro", "0173"}).results[0].sha256;
  put_in(archive, correction, sample_act("mistake"));
  auto& database = schema::opened(archive).database;
  std::vector<const schema::Shape*> shapes{&schema::units,  &schema::files,       &schema::results, &schema::parameters,
                                           &schema::inputs, &schema::corrections, &schema::facts,   &schema::events};
  for (const auto* const shape : shapes) {
    allow_changes(archive, shape->name);
    for (const auto& column : shape->columns) {
      const auto rows =
          database.ask("SELECT " + column + " FROM " + shape->name + " WHERE " + column + " IS NOT NULL LIMIT 1");
      if (rows.empty()) continue;
      const database::Value before = rows[0][0];
      database::Value after = before;
      if (auto* whole = std::get_if<std::int64_t>(&after)) *whole += 1'000'000'007;
      if (auto* real = std::get_if<double>(&after)) *real += 1e-12;
      const auto is_there = [&] {
        return !database.ask("SELECT 1 FROM " + shape->name + " WHERE " + column + " = ?", {after}).empty();
      };
      if (auto* text = std::get_if<std::string>(&after)) {  // no other row has this text: the change can be undone
        for (int bit = 1; bit < 128 && is_there(); bit *= 2)
          text->back() = static_cast<char>(std::get<std::string>(before).back() ^ bit);
      }
      if (auto* bytes = std::get_if<database::Bytes>(&after)) bytes->data[bytes->data.size() / 2] ^= 1;
      const std::string change = "UPDATE " + shape->name + " SET " + column + " = ? WHERE " + column + " = ?";
      try {
        database.run(change, {after, before});
      } catch (const database::Refusal&) {
        continue;  // a key that is there already
      }
      EXPECT_FALSE(changes_of(archive).empty()) << shape->name << "." << column;
      database.run(change, {before, after});
    }
  }
  expect_sound(archive);
}

void missing_and_added_rows_are_found(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  put_in(archive, fleet(place), sample_act());
  auto& database = schema::opened(archive).database;
  database.run("INSERT INTO corrections (result, reason, who, corrected) VALUES (1, 'x', 'x', 'x')");
  const auto check = verify_archive(archive);
  ASSERT_EQ(check.problems.size(), 1u);
  EXPECT_NE(check.problems[0].text().find("corrections"), std::string::npos);
  database.script(database.server() ? "ALTER TABLE parameters DISABLE TRIGGER ALL"
                                    : "DROP TRIGGER parameters_no_DELETE");
  database.script("DELETE FROM parameters WHERE value = (SELECT MAX(value) FROM parameters)");
  EXPECT_GT(changes_of(archive).size(), 1u);
}

void triggers_that_are_missing_or_added_are_found(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  put_in(archive, fleet(place), sample_act());
  EXPECT_TRUE(verify_archive(archive).problems.empty());
  allow_changes(archive, "results");
  const auto missing = texts_of(verify_archive(archive).problems);
  ASSERT_EQ(missing.size(), 1u);
  EXPECT_NE(missing[0].find("table results"), std::string::npos) << missing[0];
  auto& database = schema::opened(archive).database;
  if (database.server())
    database.script("CREATE TRIGGER other AFTER INSERT ON files EXECUTE FUNCTION tumble_refuse()");
  else
    database.script("CREATE TRIGGER other AFTER INSERT ON files BEGIN SELECT RAISE(IGNORE); END");
  const auto added = texts_of(verify_archive(archive).problems);
  ASSERT_EQ(added.size(), 2u);
  EXPECT_NE(added[1].find("other"), std::string::npos) << added[1];
}

/// One bit of each byte of a result and of each event, one after the other.
void every_byte_of_results_and_events_is_covered(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  Deposit deposit;
  deposit.results.push_back(sample_deposit({}));
  put_in(archive, deposit, sample_act());
  auto& database = schema::opened(archive).database;
  allow_changes(archive, "results");
  allow_changes(archive, "events");
  const auto packed = database::bytes(database.ask("SELECT packed FROM results").at(0), 0);
  for (std::size_t i = 0; i < packed.size(); ++i) {
    auto changed = packed;
    changed[i] = static_cast<char>(changed[i] ^ (1 << i % 8));
    database.run("UPDATE results SET packed = ?", {database::Bytes{changed}});
    EXPECT_FALSE(changes_of(archive).empty()) << "byte " << i << " of " << packed.size();
  }
  for (const std::string& cut : {packed.substr(0, packed.size() - 1), packed.substr(0, packed.size() - 72)}) {
    database.run("UPDATE results SET packed = ?", {database::Bytes{cut}});
    EXPECT_FALSE(changes_of(archive).empty()) << "a result without its end";
  }
  database.run("UPDATE results SET packed = ?", {database::Bytes{packed}});
  expect_sound(archive);
  for (const auto& event : database.ask(schema::select_all(schema::events)))
    for (std::size_t c = 2; c < schema::events.columns.size(); ++c) {
      const auto* const cell = std::get_if<std::string>(&event[c]);
      const std::string change = "UPDATE events SET " + schema::events.columns[c] + " = ? WHERE chain = ? AND seq = ?";
      for (std::size_t i = 0; cell && i < cell->size(); ++i) {
        std::string changed = *cell;
        changed[i] = static_cast<char>(changed[i] ^ 1);
        database.run(change, {changed, event[0], event[1]});
        EXPECT_FALSE(changes_of(archive).empty()) << schema::events.columns[c] << ", byte " << i;
      }
      if (cell) database.run(change, {*cell, event[0], event[1]});
    }
  expect_sound(archive);
}

void files_may_lie_in_the_database(const ArchivePlace& place) {
  make_archive(place.address, files_in_database, sample_act());
  Archive archive(place.address);
  EXPECT_TRUE(archive.folder().empty());
  std::string large;
  for (int i = 0; i < 400'000; ++i) large += std::to_string(static_cast<unsigned>(i) * 2654435761u) + "\n";  // 3 parts
  Deposit deposit;
  deposit.files.push_back({.path = write_file(place, "large.csv", large), .name = "large.csv", .unit = {"gyro", "1"}});
  put_in(archive, deposit, sample_act());
  write_stored(archive, sha256_of(large), place.folder + "/back.csv");
  EXPECT_EQ(sha256_of_file(place.folder + "/back.csv"), sha256_of(large));
  expect_sound(archive);
  auto& database = schema::opened(archive).database;
  EXPECT_GT(database::integer(database.ask("SELECT COUNT(*) FROM contents").at(0), 0), 1);
  allow_changes(archive, "contents");
  auto part = database::bytes(database.ask("SELECT packed FROM contents WHERE part = 1").at(0), 0);
  part[1000] = static_cast<char>(part[1000] ^ 4);
  database.run("UPDATE contents SET packed = ? WHERE part = 1", {database::Bytes{part}});
  EXPECT_EQ(changes_of(archive).size(), 1u);
}

}  // namespace

std::vector<ArchiveCase> cases_of_changes() {
  return {
      {"ChangedCellsAreFound", changed_cells_are_found},
      {"MissingAndAddedRowsAreFound", missing_and_added_rows_are_found},
      {"TriggersThatAreMissingOrAddedAreFound", triggers_that_are_missing_or_added_are_found},
      {"EveryByteOfResultsAndEventsIsCovered", every_byte_of_results_and_events_is_covered},
      {"FilesMayLieInTheDatabase", files_may_lie_in_the_database},
  };
}

}  // namespace tumble::testing
