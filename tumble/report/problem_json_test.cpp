#include "tumble/report/problem_json.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

const Problems problems{within(Where{.file = "a b.csv",
                                     .line = 3,
                                     .column = 2,
                                     .channel = "gyro",
                                     .place = say("line {}, column {} '{}'", 3, 2, Name{"gyro"})},
                               say("'{}' is not a number", std::string("x"))),
                        within(Where{.time = 2.5, .place = "outer"}, say("{} of {}", 1.5, say("n {}", Name{"m"})))};

TEST(ProblemJson, HasCodePatternValuesAndPlaceBesideTheMessage) {
  const auto json = nlohmann::json::parse(problems_to_json("bad_file", problems, Language::chinese));
  EXPECT_EQ(json[0]["code"], "bad_file");
  EXPECT_EQ(json[0]["message"], "第 3 行第 2 列“gyro”：“x”不是数值");
  EXPECT_EQ(json[0]["pattern"], "'{}' is not a number");
  EXPECT_EQ(json[0]["values"][0]["name"], "x");
  EXPECT_EQ(json[0]["where"]["line"], 3);
  EXPECT_EQ(json[0]["where"]["channel"], "gyro");
  EXPECT_EQ(json[1]["values"][0]["number"], 1.5);
  EXPECT_EQ(json[1]["values"][1]["values"][0]["name"], "m");
}

TEST(ProblemJson, IsReadAsItWasWritten) {
  const std::string text = problems_to_json("x", problems, Language::english);
  const CodedProblems read = coded_problems_from_json(text);
  EXPECT_EQ(read.code, "x");
  EXPECT_EQ(read.problems, problems);
  EXPECT_EQ(problems_to_json("x", read.problems, Language::english), text);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "problems cannot be read"},
                      [&] { coded_problems_from_json("[{}]"); }));
}

TEST(ProblemJson, AListKeepsItsNames) {
  const std::vector<std::string> names{"a", "b"};
  const Problem problem = say("columns are {}", fmt::join(names, ", "));
  const auto read = coded_problems_from_json(problems_to_json("x", {problem}, Language::english));
  EXPECT_EQ(read.problems.at(0).text(), "columns are a, b");
  EXPECT_EQ(read.problems.at(0).what.values.at(0).names, names);
}

}  // namespace
}  // namespace tumble
