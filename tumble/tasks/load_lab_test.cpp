#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tumble/tasks/certificate.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

struct LabFile : ::testing::Test {
  std::filesystem::path folder =
      std::filesystem::temp_directory_path() /
      ("tumble_lab_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
  std::string file = (folder / "lab.toml").string();

  void SetUp() override { std::filesystem::create_directories(folder); }
  void TearDown() override { std::filesystem::remove_all(folder); }
  void write(const std::string& text) const { std::ofstream(file) << text; }

  std::vector<std::string> problems(const std::string& text, const Sets& sets = {}) const {
    write(text);
    try {
      load_lab(file, sets);
    } catch (const Error& error) {
      return texts_of(error.problems);
    }
    return {};
  }
};

TEST_F(LabFile, OfTheExamplesIsComplete) {
  const auto details = load_lab(std::string(TUMBLE_SOURCE_DIR) + "/examples/lab.toml", {});
  EXPECT_TRUE(details.laboratory.logo.starts_with("data:image/svg+xml;base64,"));
  Estimate estimate;
  estimate.instrument_model = "gyro", estimate.instrument_serial = "1";
  estimate.verdicts = {{"bias", Verdict::Outcome::pass, {.upper = bound(1.0, "deg/h")}}};
  EXPECT_TRUE(missing_details(details, estimate).empty());
  EXPECT_TRUE(wrong_details(details).empty());
  EXPECT_EQ(iso_date(*details.equipment.at(0).due), "2027-01-31");
  EXPECT_NEAR(details.conditions.at(0).value, 296.15, 1e-12);
  EXPECT_NEAR(*details.conditions.at(0).uncertainty, 0.5, 1e-15);
}

TEST_F(LabFile, ValuesOfTheCommandLineReplaceThoseOfTheFile) {
  write("[certificate]\nnumber = \"1\"\nissued = 2026-01-02\n");
  const auto details = load_lab(file, {{"certificate.number", "2"},
                                       {"certificate.issued", "2026-02-03"},
                                       {"customer.name", "C"},
                                       {"certificate.rule", "risk:0.05"}});
  EXPECT_EQ(details.number, "2");
  EXPECT_EQ(iso_date(*details.issued), "2026-02-03");
  EXPECT_EQ(details.customer.name, "C");
  EXPECT_EQ(details.rule->amount, 0.05);
}

TEST_F(LabFile, TextThatNobodyCanSeeIsNone) {
  write(
      "[laboratory]\nname = \"\\u0000\\u202e \\u000b\"\ncity = \" a\\u0001b \"\n"
      "[certificate]\nremarks = [\"\", \" \\u0007\", \"one\"]\n");
  const auto details = load_lab(file, {});
  EXPECT_EQ(details.laboratory.contact.name, "");
  EXPECT_EQ(details.laboratory.contact.city, "a b");
  EXPECT_EQ(details.remarks, std::vector<std::string>{"one"});
}

TEST_F(LabFile, EveryProblemIsNamedWithItsLine) {
  const auto found = problems(
      "[laboratory]\nnam = \"x\"\n[certificate]\nbegun = 2026-13-01\nended = \"yesterday\"\nissued = 2026-02-30\nrule "
      "= \"strict\"\n"
      "language = \"fr\"\n[[condition]]\nname = \"t\"\nvalue = \"warm\"\n[[equipment]]\ndue = 5\n[[person]]\nsigns = "
      "1\n");
  // A date that TOML itself refuses ends the reading there.
  EXPECT_FALSE(found.empty());
  const auto rest = problems(
      "[laboratory]\nnam = \"x\"\n[certificate]\nended = \"yesterday\"\nissued = \"2026-02-30\"\nrule = \"strict\"\n"
      "language = \"fr\"\n[[condition]]\nname = \"t\"\nvalue = \"warm\"\n[[equipment]]\ndue = 5\n[[person]]\nsigns = "
      "1\n");
  const auto has = [&](const std::string& words) {
    return std::ranges::any_of(rest, [&](const auto& one) { return one.find(words) != std::string::npos; });
  };
  for (const char* words :
       {":2: [laboratory]: unknown key 'nam'", ":4: [certificate]: ended: a date", ":5: [certificate]: issued: a date",
        ":6: [certificate]: rule: rule 'strict'", ":7: [certificate]: language: 'fr'", ":10: [[condition]]: value",
        ":12: [[equipment]]: due: a date", "[[equipment]]: name is missing", "[[person]]: signs: true or false"})
    EXPECT_TRUE(has(words)) << words;
}

TEST_F(LabFile, SetsWithoutASectionAreRefused) {
  EXPECT_EQ(problems("", {{"number", "1"}, {"person.name", "x"}, {"certificate.nmber", "3"}}).size(), 3u);
}

TEST_F(LabFile, BlanksAtTheEndsOfTextsAreRemoved) {
  write("[customer]\nname = \"  A B \\n\"\n");
  EXPECT_EQ(load_lab(file, {}).customer.name, "A B");
}

TEST_F(LabFile, AListMustBeAList) {
  EXPECT_EQ(problems("person = 3\n").size(), 1u);
  EXPECT_EQ(problems("[person]\nname = \"x\"\n").size(), 1u);
  EXPECT_EQ(problems("person = [1, 2]\n").size(), 1u);  // one message for both
}

}  // namespace
}  // namespace tumble
