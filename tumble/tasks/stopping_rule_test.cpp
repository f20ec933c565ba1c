#include "tumble/tasks/stopping_rule.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// A plan of two segments with these lines in each.
std::string plan_text(const std::string& first, const std::string& second = "") {
  return "title = \"rest\"\nmethod = \"static_bias\"\n[channels]\nsignal = \"gyro_z\"\n"
         "[rig]\nkind = \"rate_table\"\n[[schedule]]\nlabel = \"rest\"\nduration = \"1 h\"\n" +
         first + "[[schedule]]\nlabel = \"rest\"\nduration = \"1 h\"\nrun = 2\n" + second;
}

std::map<std::string, StoppingRule> rules_of(const std::string& text) {
  const ScratchFolder scratch;
  std::ofstream(scratch.file("plan.toml")) << text;
  return stopping_rules(load_plan(scratch.file("plan.toml"), {}));
}

/// Whether the rules of the plan are refused with such a problem.
::testing::AssertionResult refuses_rules(const std::string& text, const Asked& asked) {
  return refuses(Error::Kind::bad_input, asked, [&] { rules_of(text); });
}

TEST(StoppingRule, IsReadInTheUnitThatIsWritten) {
  const StoppingRule rule = parse_stopping_rule("sd(bias) <= 0.002 deg/h", 600.0);
  EXPECT_EQ(rule.parameter, "bias");
  EXPECT_NEAR(rule.sd, 0.002 * 3.14159265358979 / 180.0 / 3600.0, 1e-20);
  EXPECT_EQ(rule.unit.text(), "deg/h");
  EXPECT_EQ(rule.at_least, 600.0);
}

TEST(StoppingRule, OthersAreRefusedWithWhatWouldBeAccepted) {
  for (const char* text : {"", "bias <= 1 deg/h", "sd(bias) < 1 deg/h", "sd() <= 1 deg/h", "sd(bias) <= -1 deg/h",
                           "sd(bias) <= 0 deg/h", "<= 1 deg/h sd(bias)", "sd(bias) x <= 1 deg/h"})
    EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "sd(bias) <= 0.002 deg/h"}, [&] {
      parse_stopping_rule(text, 1.0);
    })) << text;
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"furlong"}},
                      [] { parse_stopping_rule("sd(bias) <= 1 furlong", 1.0); }));
}

TEST(StoppingRule, OfAPlanIsThatOfItsSegments) {
  const std::string rule = "until = \"sd(bias) <= 1 deg/h\"\nat_least = \"10 min\"\n";
  const auto rules = rules_of(plan_text(rule, rule));
  ASSERT_EQ(rules.size(), 1u);
  EXPECT_EQ(rules.at("rest").at_least, 600.0);
  EXPECT_TRUE(rules_of(plan_text("")).empty());
}

TEST(StoppingRule, ProblemsHaveTheirLine) {
  const std::string until = "until = \"sd(bias) <= 1 deg/h\"\n";
  EXPECT_TRUE(refuses_rules(plan_text(until), {.values = {"at_least"}, .line = 7}));
  EXPECT_TRUE(refuses_rules(plan_text(until + "at_least = \"1 h\"\n"),
                            {.pattern = "shorter than the duration", .key = "at_least", .line = 11}));
  EXPECT_TRUE(
      refuses_rules(plan_text("at_least = \"1 min\"\n"), {.pattern = "`until`", .key = "at_least", .line = 10}));
  EXPECT_TRUE(refuses_rules(plan_text("until = \"bias\"\nat_least = \"1 min\"\n"), {.line = 10}));
  EXPECT_TRUE(refuses_rules(plan_text("untill = \"sd(bias) <= 1 deg/h\"\n"), {.values = {"untill", "until"}}));
}

TEST(StoppingRule, SegmentsOfOneLabelShareIt) {
  const std::string rule = "until = \"sd(bias) <= 1 deg/h\"\nat_least = \"10 min\"\n";
  const Asked different{.values = {"rest"}, .pattern = "different stopping rules"};
  EXPECT_TRUE(refuses_rules(plan_text(rule), different));
  const std::string other = "until = \"sd(bias) <= 2 deg/h\"\nat_least = \"10 min\"\n";
  EXPECT_TRUE(refuses_rules(plan_text(rule, other), different));
}

}  // namespace
}  // namespace tumble
