#include "tumble/tasks/stopping_rule.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

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

std::string problems_of(const std::string& text) try {
  rules_of(text);
  return "";
} catch (const Error& error) {
  return error.what();
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
    try {
      parse_stopping_rule(text, 1.0);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("sd(bias) <= 0.002 deg/h"), std::string::npos) << error.what();
    }
  EXPECT_THROW(parse_stopping_rule("sd(bias) <= 1 furlong", 1.0), Error);
}

TEST(StoppingRule, OfAPlanIsThatOfItsSegments) {
  const std::string rule = "until = \"sd(bias) <= 1 deg/h\"\nat_least = \"10 min\"\n";
  const auto rules = rules_of(plan_text(rule, rule));
  ASSERT_EQ(rules.size(), 1u);
  EXPECT_EQ(rules.at("rest").at_least, 600.0);
  EXPECT_TRUE(rules_of(plan_text("")).empty());
}

TEST(StoppingRule, ProblemsHaveTheirLine) {
  const std::string without = problems_of(plan_text("until = \"sd(bias) <= 1 deg/h\"\n"));
  EXPECT_NE(without.find("plan.toml:7: [[schedule]]: at_least is missing"), std::string::npos) << without;
  EXPECT_NE(problems_of(plan_text("until = \"sd(bias) <= 1 deg/h\"\nat_least = \"1 h\"\n")).find("must be shorter"),
            std::string::npos);
  EXPECT_NE(problems_of(plan_text("at_least = \"1 min\"\n")).find("is for a segment with `until`"), std::string::npos);
  EXPECT_NE(problems_of(plan_text("until = \"bias\"\nat_least = \"1 min\"\n")).find("plan.toml:10"), std::string::npos);
  const std::string misspelt = problems_of(plan_text("untill = \"sd(bias) <= 1 deg/h\"\n"));
  EXPECT_NE(misspelt.find("did you mean 'until'?"), std::string::npos) << misspelt;
}

TEST(StoppingRule, SegmentsOfOneLabelShareIt) {
  const std::string rule = "until = \"sd(bias) <= 1 deg/h\"\nat_least = \"10 min\"\n";
  EXPECT_NE(problems_of(plan_text(rule)).find("different stopping rules"), std::string::npos);
  EXPECT_NE(problems_of(plan_text(rule, "until = \"sd(bias) <= 2 deg/h\"\nat_least = \"10 min\"\n"))
                .find("different stopping rules"),
            std::string::npos);
}

}  // namespace
}  // namespace tumble
