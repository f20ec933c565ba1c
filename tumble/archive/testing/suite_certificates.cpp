// A certificate number belongs to one result, also where several laboratories' stations ask for it at once; and what a
// database swallows is not acknowledged.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>

#include "tumble/archive/history.hpp"
#include "tumble/archive/schema/chain.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/archive/testing/suite_helpers.hpp"
#include "tumble/archive/transfer.hpp"
#include "tumble/archive/verify.hpp"
#include "tumble/formats/checksum.hpp"

namespace tumble::testing {

namespace {

/// A certificate as a deposit: a file that holds `text`.
Deposit certificate_of(const ArchivePlace& place, const std::string& result, const std::string& number,
                       const std::string& text, const std::string& rule = "simple", const std::string& language = {}) {
  std::string name = number + text;
  std::erase_if(name, [](char letter) { return letter == '/' || letter == ' '; });
  Deposit deposit;
  deposit.certificates.push_back(
      {write_file(place, name + ".html", text), result, number, rule, "A. Example", "2026-03-31"});
  deposit.certificates.back().language = language;
  return deposit;
}

std::string result_of(const Archive& archive, const std::string& serial, std::size_t index = 0) {
  return unit_record(archive, {"gyro", serial}).results.at(index).sha256;
}

void a_certificate_number_belongs_to_one_result(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  put_in(archive, fleet(place), sample_act());
  const auto first = result_of(archive, "0173"), other = result_of(archive, "0174");
  const auto put = [&](const Deposit& deposit) {
    return refusal_of([&] { put_in(archive, deposit, {"Li Wei", "2026-04-01T08:00:00Z", {}}); });
  };
  const auto input = Error::Kind::bad_input;
  const Asked of_this_result{.values = {"2026-7", "Li Wei"}, .pattern = "another certificate on this result"};
  EXPECT_TRUE(put(certificate_of(place, first, "2026-7", "in English")).empty());
  EXPECT_TRUE(put(certificate_of(place, first, "2026-7", "in Chinese", "simple", "zh")).empty()) << "a form of it";
  EXPECT_TRUE(put(certificate_of(place, first, "2026-7", "in English")).empty()) << "the same again";
  EXPECT_TRUE(refuses(input, of_this_result, put(certificate_of(place, first, "2026-7", "with another customer"))));
  EXPECT_TRUE(refuses(input, Asked{.part = "2026\u20117"},
                      put(certificate_of(place, other, "2026\u20117", "a number that looks the same"))));
  EXPECT_TRUE(refuses(
      input,
      Asked{.values = {"2026-7", "gyro", "0173", "2026-04-01T08:00:00Z", "Li Wei"}, .pattern = "certificate.replaces"},
      put(certificate_of(place, other, "2026-7", "of another unit"))));
  EXPECT_TRUE(refuses(input, Asked{.values = {"2026-7"}},
                      put(certificate_of(place, result_of(archive, "0173", 1), "2026-7", "of another result"))));
  EXPECT_TRUE(
      refuses(input, of_this_result, put(certificate_of(place, first, "2026-7", "by another rule", "guarded:1"))));
  EXPECT_TRUE(put(certificate_of(place, first, "2026-7-A1", "by another rule", "guarded:1")).empty());
  EXPECT_TRUE(put(certificate_of(place, other, "2026-8", "of another unit")).empty());
  EXPECT_EQ(unit_record(archive, {"gyro", "0173"}).certificates.size(), 3u);
  EXPECT_EQ(unit_record(archive, {"gyro", "0174"}).certificates.size(), 1u);
  EXPECT_TRUE(verify_archive(archive).shared_numbers.empty());
  expect_sound(archive);
}

/// Ends with 0 where the archive took the certificate, with 3 where it refused the number, else with 1.
[[noreturn]] void put_in_and_end(const ArchivePlace& place, const Deposit& deposit, int begin) {
  char go = 0;
  if (read(begin, &go, 1) < 0) _exit(1);
  const Refused refusal = refusal_of([&] {
    Archive archive(place.address);
    put_in(archive, deposit, sample_act());
  });
  _exit(refusal.empty() ? 0 : refuses(Error::Kind::bad_input, Asked{.pattern = "certificate number"}, refusal) ? 3 : 1);
}

void of_processes_that_ask_at_once_one_gets_a_number(const ArchivePlace& place) {
  constexpr int stations = 8;
  std::vector<Deposit> deposits;
  {
    Archive archive = new_archive(place);
    Deposit results;
    for (int i = 0; i < stations; ++i) results.results.push_back(sample_deposit({.serial = std::to_string(i)}));
    put_in(archive, results, sample_act());
    for (int i = 0; i < stations; ++i)
      deposits.push_back(certificate_of(place, result_of(archive, std::to_string(i)), "2026-0001", std::to_string(i)));
  }
  int gate[2];
  ASSERT_EQ(pipe(gate), 0);
  std::vector<pid_t> children;
  for (const auto& deposit : deposits) {
    children.push_back(fork());
    if (children.back() != 0) continue;
    close(gate[1]);  // the end of the pipe, when the parent closes it, is the sign to begin
    put_in_and_end(place, deposit, gate[0]);
  }
  close(gate[1]);
  int taken = 0, refused = 0;
  for (const pid_t child : children) {
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    taken += WEXITSTATUS(status) == 0;
    refused += WEXITSTATUS(status) == 3;
  }
  close(gate[0]);
  EXPECT_EQ(taken, 1);
  EXPECT_EQ(refused, stations - 1);
  const Archive archive(place.address);
  EXPECT_TRUE(verify_archive(archive).shared_numbers.empty());
  expect_sound(archive);
}

/// As programs of before put them in: without a look at the number.
void put_unlooked(Archive& archive, const Deposit& deposit, const std::string& serial) {
  const auto& one = deposit.certificates.front();
  const auto sha256 = sha256_of_file(one.path);
  auto& open = schema::opened(archive);
  storage::keep(open.files(), one.path);
  open.database.transact([&] {
    schema::Change change(open.database, "Li Wei", "2026-01-01T08:00:00Z");
    change.append(schema::chain_of_unit("gyro", serial), {"certificate", sha256, {}, one.number},
                  {{&schema::certificates,
                    {{sha256, one.number, schema::number_of(one.result), std::string("html"), one.rule, one.issued_by,
                      one.issued}}}});
  });
}

void numbers_shared_from_before_are_reported(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  put_in(archive, fleet(place), sample_act());
  const auto first = result_of(archive, "0173"), other = result_of(archive, "0174");
  put_unlooked(archive, certificate_of(place, first, "2026-1", "first"), "0173");
  put_unlooked(archive, certificate_of(place, other, "2026-1", "other"), "0174");
  EXPECT_EQ(unit_record(archive, {"gyro", "0173"}).certificates.size(), 1u);
  EXPECT_EQ(unit_record(archive, {"gyro", "0174"}).certificates.size(), 1u);
  const auto check = verify_archive(archive);
  EXPECT_TRUE(check.problems.empty()) << check.problems.front().text();
  ASSERT_EQ(check.shared_numbers.size(), 1u);
  for (const char* part : {"'2026-1'", "2 results", "gyro/0173", "gyro/0174"})
    EXPECT_NE(check.shared_numbers[0].text().find(part), std::string::npos) << check.shared_numbers[0].text();
  for (const auto& result : {first, other})
    EXPECT_TRUE(
        refuses(Error::Kind::bad_input, Asked{.values = {"2026-1"}, .pattern = "certificate number"},
                [&, of = result] { put_in(archive, certificate_of(place, of, "2026-1", "once more"), sample_act()); }));
  EXPECT_EQ(verify_archive(archive).shared_numbers.size(), 1u);
}

void an_import_keeps_the_numbers_of_two_laboratories(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  Deposit ours, theirs;
  ours.results.push_back(sample_deposit({.serial = "1"}));
  theirs.results.push_back(sample_deposit({.serial = "2"}));
  put_in(archive, ours, sample_act());
  put_in(archive, certificate_of(place, result_of(archive, "1"), "2026-1", "ours"), sample_act());
  const std::string file = place.folder + "/theirs.db";
  make_archive(file, {}, sample_act());
  {
    Archive other(file);
    put_in(other, theirs, sample_act());
    put_in(other, certificate_of(place, result_of(other, "2"), "2026-1", "theirs"), sample_act());
  }
  import_archive(archive, file, sample_act(), {});
  EXPECT_EQ(unit_record(archive, {"gyro", "2"}).certificates.size(), 1u);
  EXPECT_EQ(verify_archive(archive).shared_numbers.size(), 1u);
  expect_sound(archive);
}

void what_the_database_swallows_is_not_acknowledged(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  auto& database = schema::opened(archive).database;
  if (database.server())
    database.script("CREATE RULE swallow AS ON INSERT TO results DO INSTEAD NOTHING");
  else
    database.script("CREATE TRIGGER swallow BEFORE INSERT ON results BEGIN SELECT RAISE(IGNORE); END");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "0 of 1 rows of the table results"},
                      [&] { put_in(archive, fleet(place), sample_act()); }));
  EXPECT_TRUE(archived_units(archive).empty());
}

void a_changed_version_of_the_tables_is_found(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  auto& database = schema::opened(archive).database;
  for (const char* const change : {"UPDATE schema_version SET version = 9 WHERE version = 2",
                                   "UPDATE schema_version SET version = 2, program = "
                                   "'9.9' WHERE version = 9",
                                   "DELETE FROM schema_version WHERE version = 1"}) {
    database.script(change);
    const auto problems = texts_of(verify_archive(archive).problems);
    ASSERT_FALSE(problems.empty()) << change;
    EXPECT_NE(problems[0].find("schema_version"), std::string::npos) << problems[0];
  }
}

}  // namespace

std::vector<ArchiveCase> cases_of_certificates() {
  return {{"ACertificateNumberBelongsToOneResult", a_certificate_number_belongs_to_one_result},
          {"OfProcessesThatAskAtOnceOneGetsANumber", of_processes_that_ask_at_once_one_gets_a_number},
          {"NumbersSharedFromBeforeAreReported", numbers_shared_from_before_are_reported},
          {"AnImportKeepsTheNumbersOfTwoLaboratories", an_import_keeps_the_numbers_of_two_laboratories},
          {"WhatTheDatabaseSwallowsIsNotAcknowledged", what_the_database_swallows_is_not_acknowledged},
          {"AChangedVersionOfTheTablesIsFound", a_changed_version_of_the_tables_is_found}};
}

}  // namespace tumble::testing
