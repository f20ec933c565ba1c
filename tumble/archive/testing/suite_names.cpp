// Names that nobody expects, notes, clocks that go backwards.
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

/// Text that cannot be compressed.
std::string long_name(std::size_t bytes) {
  std::string text;
  for (std::size_t i = 0; text.size() < bytes; ++i) text += sha256_of(std::to_string(i));
  return text.substr(0, bytes);
}

void names_that_no_index_holds_are_refused(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  Deposit deposit;
  deposit.results.push_back(sample_deposit({.serial = long_name(10'000)}));
  deposit.results.push_back(sample_deposit({.serial = std::string("a\0b", 3)}));
  for (auto& result : deposit.results) result.file = "result.json";
  EXPECT_TRUE(refuses(Error::Kind::bad_input,
                      std::vector<Asked>{{.values = {"result.json", "10000"}},
                                         {.values = {"result.json"}, .pattern = "a character of value 0"}},
                      [&] { put_in(archive, deposit, sample_act()); }));
  EXPECT_TRUE(archived_units(archive).empty());
}

void hostile_names_are_kept_as_they_are(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  const std::vector<std::string> names{"o'hara\"; DROP TABLE units; --",
                                       "a/b/../c",
                                       "陀螺-零一",
                                       "\xF0\x9F\x9B\xB0",
                                       " blank ",
                                       "%s{}\\",
                                       long_name(1000),
                                       "line\nbreak\ttab"};
  Deposit deposit;
  for (const auto& name : names) deposit.results.push_back(sample_deposit({.serial = name}));
  put_in(archive, deposit, {"O'Neill \"x\"", "2026-03-02T09:00:00Z", {}});
  EXPECT_EQ(archived_units(archive).size(), names.size());
  for (const auto& name : names) {
    EXPECT_EQ(find_unit(archive, name).serial, name);
    EXPECT_EQ(unit_record(archive, find_unit(archive, "gyro/" + name)).results.size(), 1u) << name;
    put_note(archive, {"gyro/" + name, "remark", name, {}}, sample_act());
  }
  expect_sound(archive);
  const std::string file = place.folder + "/hostile.db";
  export_unit(archive, {"gyro", names[0]}, file, sample_act());
  EXPECT_EQ(unit_record(Archive(file), {"gyro", names[0]}).results.size(), 1u);
}

/// "a/b" and "c" are not "a" and "b/c".
void units_with_slashes_do_not_share_a_chain(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  const std::vector<UnitName> units{{"a/b", "c"}, {"a", "b/c"}, {"a%2Fb", "c"}};
  Deposit deposit;
  for (const auto& unit : units) {
    deposit.results.push_back(sample_deposit({.serial = unit.serial + unit.model}));
    deposit.results.back().unit = unit;
  }
  put_in(archive, deposit, sample_act());
  for (const auto& unit : units) EXPECT_EQ(unit_record(archive, unit).steps.size(), 2u) << unit.model;
  const std::string file = place.folder + "/slashes.db";
  export_unit(archive, units[1], file, sample_act());
  EXPECT_EQ(archived_units(Archive(file)).size(), 1u);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"a/b/c"}}, [&] { find_unit(archive, "a/b/c"); }));
  EXPECT_EQ(find_unit(archive, "b/c").model, "a");
  expect_sound(archive);
}

void what_is_no_time_is_refused(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  for (const char* const time : {"yesterday", "2026-13-01T00:00:00Z", "2026-11-20T09:00:00+08:00"}) {
    Deposit deposit;
    deposit.results.push_back(sample_deposit({}));
    deposit.results.back().ended = time;
    EXPECT_TRUE(
        refuses(Error::Kind::bad_input, Asked{.values = {time}}, [&] { put_in(archive, deposit, sample_act()); }));
  }
  EXPECT_TRUE(archived_units(archive).empty());
}

void a_replaced_result_replaces_none(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  Deposit first, second;
  first.results.push_back(sample_deposit({.bias = 1.0}));
  second.results.push_back(sample_deposit({.bias = 2.0}));
  second.results[0].corrects = put_in(archive, first, sample_act()).result_ids[0];
  first.results[0].corrects = put_in(archive, second, sample_act("supply")).result_ids[0];
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "was replaced or withdrawn itself, and cannot replace"},
                      [&] { put_in(archive, first, sample_act("other")); }));
  EXPECT_EQ(parameter_over_units(archive, "bias", "").values.size(), 1u);
}

void notes_say_what_is_due(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  Deposit deposit = fleet(place);
  EquipmentDeposit head;
  head.name = "head", head.serial = "7", head.certificate = "C-1", head.due = "2026-06-30";
  deposit.equipment.push_back(head);
  put_in(archive, deposit, sample_act());
  EXPECT_TRUE(due_units(archive, "2030-01-01").empty()) << "no interval is known";
  put_note(archive, {"gyro", "interval", "365 day", {}}, sample_act());
  put_note(archive, {"0174", "interval", "30 day", {}}, sample_act());
  ASSERT_EQ(due_units(archive, "2026-04-30").size(), 1u);
  EXPECT_EQ(due_units(archive, "2026-04-30")[0].unit.serial, "0174");
  EXPECT_EQ(due_units(archive, "2026-04-30")[0].due, "2026-03-31");
  EXPECT_EQ(due_units(archive, "2027-03-03").back().due, "2027-03-03");
  put_note(archive, {"0174", "retired", "dropped", {}}, sample_act());
  EXPECT_TRUE(due_units(archive, "2026-04-30").empty());
  EXPECT_EQ(due_calibrations(archive, "2026-07-01").size(), 1u);
  put_note(archive, {"head", "retired", "", {}}, sample_act());
  EXPECT_TRUE(due_calibrations(archive, "2026-07-01").empty());
  put_note(archive, {"head/7", "returned", "", {}}, sample_act());
  EXPECT_EQ(due_calibrations(archive, "2026-07-01").size(), 1u);
  const auto input = Error::Kind::bad_input;
  EXPECT_TRUE(
      refuses(input,
              std::vector<Asked>{
                  {.values = {"reparied", "repaired"}}, {.pattern = "--by NAME is missing"}, {.values = {"yesterday"}}},
              [&] {
                put_note(archive, {"0174", "reparied", "", "yesterday"}, {});
              }));
  EXPECT_TRUE(refuses(input, Asked{.values = {"soon"}}, [&] {
    put_note(archive, {"0174", "interval", "soon", {}}, sample_act());
  }));
  EXPECT_TRUE(refuses(input, Asked{.values = {"hed", "head"}}, [&] {
    put_note(archive, {"hed", "remark", "x", {}}, sample_act());
  }));
  expect_sound(archive);
}

void withdrawn_results_do_not_count(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  put_in(archive, fleet(place), sample_act());
  const std::string sha256 = unit_record(archive, {"gyro", "0173"}).results[0].sha256;
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "--reason TEXT"},
                      [&] { withdraw_result(archive, sha256, sample_act()); }));
  withdraw_result(archive, sha256, sample_act("the reference was switched off"));
  EXPECT_EQ(parameter_over_units(archive, "bias", "").values.size(), 3u);
  EXPECT_EQ(unit_record(archive, {"gyro", "0173"}).results[0].correction, "the reference was switched off");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "was replaced or withdrawn already"},
                      [&] { withdraw_result(archive, sha256, sample_act("again")); }));
  expect_sound(archive);
}

void a_clock_that_goes_backwards_changes_no_order(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  for (const char* const when : {"2026-03-02T09:00:00Z", "2026-03-01T09:00:00Z", "2025-01-01T00:00:00Z"}) {
    Deposit deposit;
    deposit.results.push_back(sample_deposit({.bias = static_cast<double>(when[6]), .ended = std::string(when)}));
    deposit.results.push_back(sample_deposit({.bias = static_cast<double>(when[9]), .ended = std::string(when)}));
    put_in(archive, deposit, {"Li Wei", when, {}});
  }
  const auto record = unit_record(archive, {"gyro", "0173"});
  ASSERT_GE(record.steps.size(), 4u);
  for (std::size_t i = 0; i < record.steps.size(); ++i)
    EXPECT_EQ(record.steps[i].number, static_cast<std::int64_t>(i + 1));
  expect_sound(archive);
}

}  // namespace

std::vector<ArchiveCase> cases_of_names_and_notes() {
  return {
      {"HostileNamesAreKeptAsTheyAre", hostile_names_are_kept_as_they_are},
      {"NamesThatNoIndexHoldsAreRefused", names_that_no_index_holds_are_refused},
      {"UnitsWithSlashesDoNotShareAChain", units_with_slashes_do_not_share_a_chain},
      {"WhatIsNoTimeIsRefused", what_is_no_time_is_refused},
      {"AReplacedResultReplacesNone", a_replaced_result_replaces_none},
      {"NotesSayWhatIsDue", notes_say_what_is_due},
      {"WithdrawnResultsDoNotCount", withdrawn_results_do_not_count},
      {"AClockThatGoesBackwardsChangesNoOrder", a_clock_that_goes_backwards_changes_no_order},
  };
}

}  // namespace tumble::testing
