#include "tumble/archive/testing/suite.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

#include "tumble/archive/history.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/archive/testing/suite_helpers.hpp"
#include "tumble/archive/verify.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::testing {

Archive new_archive(const ArchivePlace& place) {
  make_archive(place.address, place.folder + "/kept", sample_act());
  return Archive(place.address);
}

std::string write_file(const ArchivePlace& place, const std::string& name, const std::string& text) {
  const std::string path = place.folder + "/" + name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

Deposit fleet(const ArchivePlace& place) {
  const std::string recording = write_file(place, "data.csv", "time[s],x[deg/h]\n0,1\n1,2\n");
  Deposit deposit;
  for (const double bias : {1.0, 1.2, 0.9})
    deposit.results.push_back(
        sample_deposit({.bias = bias,
                        .ended = "2026-03-0" + std::to_string(deposit.results.size() + 1) + "T12:00:00Z",
                        .recording_sha256 = sha256_of_file(recording)}));
  deposit.results.push_back(sample_deposit({.serial = "0174", .bias = 5.0}));
  deposit.files.push_back({.path = recording, .name = "data.csv"});
  return deposit;
}

void expect_sound(const Archive& archive) {
  const auto problems = changes_of(archive);
  EXPECT_TRUE(problems.empty()) << problems.front();
}

std::vector<std::string> changes_of(const Archive& archive) {
  auto problems = texts_of(verify_archive(archive).problems);
  std::erase_if(problems, [](const std::string& problem) { return problem.find("trigger") != std::string::npos; });
  return problems;
}

void allow_changes(const Archive& archive, const std::string& table) {
  auto& database = schema::opened(archive).database;
  database.script(database.server() ? "ALTER TABLE " + table + " DISABLE TRIGGER ALL"
                                    : "DROP TRIGGER " + table + "_no_UPDATE; PRAGMA synchronous = OFF");
}

namespace {

void keeps_what_is_put_in(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  const Deposited done = put_in(archive, fleet(place), sample_act());
  EXPECT_EQ(done.results, 4u);
  EXPECT_EQ(done.files, 1u);
  const UnitRecord record = unit_record(archive, find_unit(archive, "0173"));
  ASSERT_EQ(record.results.size(), 3u);
  EXPECT_EQ(record.results[1].ended, "2026-03-02T12:00:00Z");
  EXPECT_EQ(record.results[0].who, "Li Wei");
  ASSERT_EQ(record.files.size(), 1u);
  EXPECT_EQ(record.files[0].role, "recording");
  EXPECT_EQ(record.steps.size(), 5u);  // the unit, three results, a file
  EXPECT_EQ(result_text(archive, record.results[0].sha256),
            sample_json({.bias = 1.0, .ended = "2026-03-01T12:00:00Z", .recording_sha256 = record.files[0].sha256}));
  ASSERT_EQ(archived_units(archive).size(), 2u);
  EXPECT_EQ(archived_units(archive)[0].results, 3u);
  expect_sound(archive);
}

void ingest_is_idempotent(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  put_in(archive, fleet(place), sample_act());
  const std::string heads = verify_archive(archive).heads;
  const Deposited again = put_in(archive, fleet(place), {"Somebody", "2027-01-01T00:00:00Z", {}});
  EXPECT_EQ(again.results + again.files, 0u);
  EXPECT_EQ(again.known, 5u);
  EXPECT_EQ(verify_archive(archive).heads, heads);
}

void refuses_changes_and_deletions(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  put_in(archive, fleet(place), sample_act());
  for (const auto* const sql :
       {"UPDATE results SET who = 'me'", "DELETE FROM results", "UPDATE events SET who = 'me'", "DELETE FROM events",
        "UPDATE parameters SET value = 0", "DELETE FROM units", "DELETE FROM files", "DELETE FROM facts"})
    EXPECT_THROW(schema::opened(archive).database.script(sql), database::Refusal) << sql;
  expect_sound(archive);
}

void corrections_keep_the_original(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  put_in(archive, fleet(place), sample_act());
  const std::string old = unit_record(archive, {"gyro", "0173"}).results[0].sha256;
  Deposit correction;
  correction.results.push_back(sample_deposit({.bias = 1.05}));
  correction.results[0].corrects = old;
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "--reason TEXT"},
                      [&] { put_in(archive, correction, sample_act()); }));
  put_in(archive, correction, sample_act("wrong serial number of the reference"));
  const UnitRecord record = unit_record(archive, {"gyro", "0173"});
  ASSERT_EQ(record.results.size(), 4u);
  const auto replaced = std::ranges::find(record.results, old, &ArchivedResult::sha256);
  EXPECT_EQ(replaced->correction, "wrong serial number of the reference");
  EXPECT_EQ(replaced->replaced_by, sha256_of(correction.results[0].json));
  EXPECT_EQ(parameter_over_units(archive, "bias", "").values.size(), 4u);
  EXPECT_FALSE(result_text(archive, old).empty());
  expect_sound(archive);
}

void all_problems_come_at_once_and_nothing_is_written(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  Deposit deposit;
  deposit.results.push_back({.json = sample_json({.serial = ""}), .file = "nameless.json"});
  deposit.results.push_back({.json = "{}", .file = "empty.json"});
  deposit.results.push_back(sample_deposit({}));
  deposit.files.push_back({.path = write_file(place, "stray.csv", "x"), .name = "stray.csv"});
  EXPECT_TRUE(refuses(Error::Kind::bad_input,
                      {{.part = "nameless.json"}, {.part = "empty.json"}, {.part = "stray.csv"}, {.pattern = "--by"}},
                      [&] { put_in(archive, deposit, {}); }));
  EXPECT_TRUE(archived_units(archive).empty());
}

void unknown_names_are_answered_with_near_ones(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  Deposit deposit = fleet(place);
  deposit.results.push_back(sample_deposit({}));
  deposit.results.back().unit = {"other", "0174"};
  put_in(archive, deposit, sample_act());
  const auto input = Error::Kind::bad_input;
  EXPECT_TRUE(refuses(input, Asked{.values = {"0172", "0173"}}, [&] { find_unit(archive, "0172"); }));
  EXPECT_TRUE(refuses(input, Asked{.values = {"0174", "gyro/0174, other/0174"}}, [&] { find_unit(archive, "0174"); }));
  EXPECT_EQ(find_unit(archive, "other/0174").model, "other");
  EXPECT_TRUE(refuses(input, Asked{.values = {"bais", "bias"}}, [&] { parameter_over_units(archive, "bais", ""); }));
  EXPECT_TRUE(refuses(input, Asked{.values = {"12", "6"}}, [&] { find_result(archive, "12"); }));
}

void writers_at_once_lose_and_double_nothing(const ArchivePlace& place) {
  new_archive(place);
  constexpr int writers = 20, each = 5;
  std::vector<Refused> ends(writers);
  std::vector<std::thread> threads;
  for (int w = 0; w < writers; ++w)
    threads.emplace_back([&, w] {
      ends[static_cast<std::size_t>(w)] = refusal_of([&] {
        Archive archive(place.address);
        for (int i = 0; i < each; ++i) {
          Deposit deposit;
          deposit.results.push_back(sample_deposit({.bias = 100.0 * w + i}));  // of one unit: one chain for all
          deposit.results.push_back(
              sample_deposit({.serial = std::to_string(w % 4), .bias = 1.0 * i}));  // some are the same
          put_in(archive, deposit, sample_act());
        }
      });
    });
  for (auto& thread : threads) thread.join();
  for (const Refused& end : ends) EXPECT_TRUE(end.empty()) << end.problems.front().text();
  const Archive archive(place.address);
  EXPECT_EQ(unit_record(archive, {"gyro", "0173"}).results.size(), static_cast<std::size_t>(writers * each));
  for (const char* const serial : {"0", "1", "2", "3"})
    EXPECT_EQ(unit_record(archive, {"gyro", serial}).results.size(), static_cast<std::size_t>(each));
  expect_sound(archive);
}

}  // namespace

const std::vector<ArchiveCase>& archive_cases() {
  static const std::vector<ArchiveCase> all = [] {
    std::vector<ArchiveCase> cases{
        {"KeepsWhatIsPutIn", keeps_what_is_put_in},
        {"IngestIsIdempotent", ingest_is_idempotent},
        {"RefusesChangesAndDeletions", refuses_changes_and_deletions},
        {"CorrectionsKeepTheOriginal", corrections_keep_the_original},
        {"AllProblemsComeAtOnceAndNothingIsWritten", all_problems_come_at_once_and_nothing_is_written},
        {"UnknownNamesAreAnsweredWithNearOnes", unknown_names_are_answered_with_near_ones},
        {"WritersAtOnceLoseAndDoubleNothing", writers_at_once_lose_and_double_nothing},
    };
    for (const auto& more : {cases_of_changes(), cases_of_names_and_notes(), cases_of_transfer(), cases_of_signatures(),
                             cases_of_certificates()})
      cases.insert(cases.end(), more.begin(), more.end());
    return cases;
  }();
  return all;
}

}  // namespace tumble::testing
