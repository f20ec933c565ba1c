// Units travel from archive to archive.
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

namespace fs = std::filesystem;

/// A unit goes out into a file and comes back, into the archive itself and into another one.
void units_travel_in_one_file(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  put_in(archive, fleet(place), sample_act());
  put_note(archive, {"0173", "adjusted", "trimmed", {}}, sample_act("it was out of limits"));
  withdraw_result(archive, unit_record(archive, {"gyro", "0173"}).results[1].sha256, sample_act("wrong rig"));
  const std::string file = place.folder + "/unit.db";
  const auto written = export_unit(archive, {"gyro", "0173"}, file, sample_act());
  EXPECT_EQ(written.results, 3u);
  EXPECT_EQ(written.files, 1u);
  EXPECT_FALSE(fs::exists(file + ".part"));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {file}, .pattern = "is there already"}, [&] {
    export_unit(archive, {"gyro", "0173"}, file, sample_act());
  }));
  const auto same = [&](const UnitRecord& a, const UnitRecord& b) {
    ASSERT_EQ(a.results.size(), b.results.size());
    for (std::size_t i = 0; i < a.results.size(); ++i) EXPECT_EQ(a.results[i].sha256, b.results[i].sha256);
    ASSERT_EQ(a.steps.size(), b.steps.size());
    for (std::size_t i = 0; i < a.steps.size(); ++i) EXPECT_EQ(a.steps[i].when, b.steps[i].when);
    EXPECT_EQ(a.results[1].correction, b.results[1].correction);
  };
  const auto record = unit_record(archive, {"gyro", "0173"});
  {
    const Archive alone(file);
    expect_sound(alone);
    same(record, unit_record(alone, {"gyro", "0173"}));
    write_stored(alone, record.files[0].sha256, place.folder + "/back.csv");
    EXPECT_EQ(sha256_of_file(place.folder + "/back.csv"), record.files[0].sha256);
  }
  const auto again = import_archive(archive, file, sample_act());
  EXPECT_EQ(again.events + again.results + again.files, 0u);
  make_archive(place.folder + "/other.db", "", sample_act());
  Archive other(place.folder + "/other.db");
  EXPECT_EQ(import_archive(other, file, sample_act()).results, 3u);
  same(record, unit_record(other, {"gyro", "0173"}));
  expect_sound(other);
  EXPECT_EQ(import_archive(other, file, sample_act()).events, 0u);
  expect_sound(other);
}

/// Two archives that both went on with a unit: nothing is lost, nothing is doubled, and who did it stays.
void archives_that_went_on_are_merged(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  put_in(archive, fleet(place), sample_act());
  const std::string file = place.folder + "/unit.db";
  export_unit(archive, {"gyro", "0173"}, file, sample_act());
  {
    Archive away(file);
    Deposit deposit;
    deposit.results.push_back(sample_deposit({.bias = 7.0}));
    deposit.results.push_back(sample_deposit({.bias = 8.0}));
    put_in(away, deposit, {"A. Example", "2026-05-01T00:00:00Z", {}});
  }
  Deposit here;
  here.results.push_back(sample_deposit({.bias = 8.0}));
  here.results.push_back(sample_deposit({.bias = 9.0}));
  put_in(archive, here, sample_act());
  const auto merged = import_archive(archive, file, {"B. Example", "2026-06-01T00:00:00Z", {}});
  EXPECT_EQ(merged.results, 1u);
  const auto record = unit_record(archive, {"gyro", "0173"});
  EXPECT_EQ(record.results.size(), 6u);
  EXPECT_TRUE(std::ranges::any_of(record.steps, [](const ArchivedStep& step) {
    return step.action == "result" && step.who == "A. Example" && step.when == "2026-05-01T00:00:00Z";
  }));
  EXPECT_TRUE(std::ranges::any_of(
      record.steps, [](const ArchivedStep& step) { return step.action == "import" && step.who == "B. Example"; }));
  expect_sound(archive);
  EXPECT_EQ(import_archive(archive, file, sample_act()).events, 0u);
  expect_sound(archive);
}

void a_changed_export_is_refused(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  put_in(archive, fleet(place), sample_act());
  const std::string file = place.folder + "/unit.db";
  export_unit(archive, {"gyro", "0173"}, file, sample_act());
  {
    database::Database database(file, false);
    database.script("DROP TRIGGER parameters_no_UPDATE");
    database.script("UPDATE parameters SET value = value + 1e-9");
  }
  const std::string before = verify_archive(archive).heads;
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"result"}, .pattern = "has changed"},
                      [&] { import_archive(archive, file, sample_act()); }));
  EXPECT_EQ(verify_archive(archive).heads, before);
}

}  // namespace

std::vector<ArchiveCase> cases_of_transfer() {
  return {
      {"UnitsTravelInOneFile", units_travel_in_one_file},
      {"ArchivesThatWentOnAreMerged", archives_that_went_on_are_merged},
      {"AChangedExportIsRefused", a_changed_export_is_refused},
  };
}

}  // namespace tumble::testing
