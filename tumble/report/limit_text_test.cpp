#include "tumble/report/limit_text.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tumble/report/legacy/legacy.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/testing/example_estimate.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

TEST(LimitText, SaysTheBoundsAsTheyWereWritten) {
  EXPECT_EQ(limit_text({.upper = bound(0.02, "deg/h")}), "<= 0.02 deg/h");
  EXPECT_EQ(limit_text({.lower = bound(-50.0, "ppm")}), ">= -50 ppm");
  EXPECT_EQ(limit_text({bound(-0.5, "deg/h"), bound(0.5, "deg/h")}), "-0.5 deg/h to 0.5 deg/h");
  EXPECT_EQ(limit_text({.upper = bound(3.0, "1")}), "<= 3");
  EXPECT_EQ(limit_text({.upper = bound(1e9, "deg/h")}), "<= 1000000000 deg/h");
  EXPECT_EQ(limit_text({.upper = bound(20.1, "degC")}), "<= 20.1 degC");
  EXPECT_EQ(limit_in_characters({.upper = bound(20.0, "ppm")}), "≤ 20 ppm");
}

// A result of before has texts alone: they give the same limits.
TEST(LegacyLimit, IsReadFromItsText) {
  for (const Limit& limit : {Limit{.upper = bound(0.02, "deg/h")}, Limit{.lower = bound(1.0, "g")},
                             Limit{bound(-72.0, "arcsec/h"), bound(0.02, "deg/h")}, Limit{.upper = bound(3.0, "1")}}) {
    const Limit again = legacy::limit_of(limit_text(limit));
    EXPECT_EQ(again.lowest(), limit.lowest());
    EXPECT_EQ(again.highest(), limit.highest());
    EXPECT_EQ(limit_text(again), limit_text(limit));
  }
}

// Who trusts the text and who trusts the numbers must read the same limit, and there must be one.
TEST(LimitOfAResult, ItsTextAndItsNumbersSayTheSame) {
  const auto whole = nlohmann::ordered_json::parse(to_json(testing::estimate()));
  const auto problem_of = [](const nlohmann::ordered_json& json) {
    return refusal_of([&] { estimate_from_json(json.dump(), "result.json"); }).problems;
  };
  auto json = whole;
  json["verdicts"][0]["limit"] = "<= 9 deg/h";
  EXPECT_TRUE(is_problem(problem_of(json).at(0), {.values = {"<= 9 deg/h"}, .key = "verdicts[0].limit"}));
  json = whole;
  json["verdicts"][0]["limit"] = "";
  EXPECT_EQ(problem_of(json).at(0).where.key, "verdicts[0].limit");
  json = whole;
  json["verdicts"][0]["limit"] = 3;
  EXPECT_EQ(problem_of(json).size(), 1u);
  json = whole;
  const std::string end = json["verdicts"][0].contains("upper") ? "upper" : "lower";
  json["verdicts"][0][end] = "5 deg/h";
  ASSERT_EQ(problem_of(json).size(), 1u) << "one fault, one complaint";
  json["verdicts"][0][end] = {{"value", nullptr}, {"unit", "deg/h"}};
  EXPECT_EQ(problem_of(json).at(0).where.key, "verdicts[0]." + end + ".value");
}

TEST(LegacyLimit, InAResultGivesTheSameVerdicts) {
  const Estimate estimate = testing::estimate();
  auto json = nlohmann::ordered_json::parse(to_json(estimate));
  for (auto& verdict : json["verdicts"]) EXPECT_EQ(verdict.erase("lower") + verdict.erase("upper"), 1u);
  const Estimate read = estimate_from_json(json.dump(), "result.json");
  EXPECT_EQ(to_json(read), to_json(estimate));
  json["verdicts"][0]["limit"] = "about 3";
  json["verdicts"][1]["limit"] = ">= 1e999 deg/h";
  const Refused refusal = refusal_of([&] { estimate_from_json(json.dump(), "result.json"); });
  EXPECT_EQ(refusal.problems.size(), 2u);
  EXPECT_TRUE(refuses(Error::Kind::bad_file,
                      {{.values = {"about 3"}, .file = "result.json", .key = "verdicts[0].limit"},
                       {.file = "result.json", .key = "verdicts[1].limit"}},
                      refusal));
}

}  // namespace
}  // namespace tumble
