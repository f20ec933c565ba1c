#include "tumble/core/settings.hpp"

#include <gtest/gtest.h>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

std::vector<Option> options() {
  return {{"rate", Option::Type::quantity, "Hz", "", {}, "", true},
          {"soak", Option::Type::quantity, "min", "90 min", {}, ""},
          {"start", Option::Type::quantity, "degC", "20 degC", {}, "", true},
          {"ratio", Option::Type::quantity, "1", "0.5", {}, ""},
          {"orders", Option::Type::integers, "1", "1,2", {}, ""},
          {"estimator", Option::Type::word, "1", "joint", {"joint", "two_stage"}, ""},
          {"robust", Option::Type::flag, "1", "false", {}, ""},
          {"points", Option::Type::integer, "1", "10", {}, ""},
          {"note", Option::Type::text, "1", "", {}, ""}};
}

TEST(Settings, DefaultsAreFilledIn) {
  const Settings settings = defaults(options());
  EXPECT_FALSE(settings.has("rate"));
  EXPECT_FALSE(settings.has("note"));
  EXPECT_EQ(settings.number("soak"), 5400.0);
  EXPECT_EQ(settings.number("start"), 293.15);
  EXPECT_EQ(settings.integers("orders"), (std::vector<int>{1, 2}));
  EXPECT_EQ(settings.word("estimator"), "joint");
  EXPECT_FALSE(settings.flag("robust"));
  EXPECT_EQ(settings.texts().at("soak"), "90 min");
  EXPECT_EQ(settings.texts().at("start"), "20 degC");
  EXPECT_EQ(settings.texts().at("ratio"), "0.5");
  EXPECT_TRUE(refuses(Error::Kind::internal, Asked{.values = {"rate"}}, [&] { settings.number("rate"); }));
}

TEST(Settings, GivenValuesOverrideAndTheLastWins) {
  Problems problems;
  const Settings settings = resolve(options(),
                                    {{"soak", "2 h", "plan.toml:3"},
                                     {"orders", "1, 3-5", "plan.toml:4"},
                                     {"robust", "true", "plan.toml:5", false},
                                     {"points", "7", "plan.toml:6", false},
                                     {"note", "as it is", "plan.toml:7"},
                                     {"rate", "100", "--set", true, true},
                                     {"start", "-20", "--set", true, true},
                                     {"points", "8", "--set", true, true}},
                                    "method m", problems);
  EXPECT_TRUE(problems.empty());
  EXPECT_EQ(settings.number("soak"), 7200.0);
  EXPECT_EQ(settings.integers("orders"), (std::vector<int>{1, 3, 4, 5}));
  EXPECT_TRUE(settings.flag("robust"));
  EXPECT_EQ(settings.integer("points"), 8);
  EXPECT_EQ(settings.word("note"), "as it is");
  EXPECT_EQ(settings.number("rate"), 100.0);
  EXPECT_EQ(settings.number("start"), -20.0 + 273.15);
  EXPECT_EQ(settings.texts().at("rate"), "100 Hz");
}

TEST(Settings, AllProblemsAtOnce) {
  Problems problems;
  const auto line = [](std::size_t number) {
    return Where{.file = "plan.toml", .line = number, .place = say("{}:{}", Name{"plan.toml"}, number)};
  };
  resolve(options(),
          {{"sok", "2 h", line(3)},
           {"soak", "2", line(4), false},
           {"soak", "2", "--set", true, true},
           {"rate", "100", line(5)},
           {"rate", "100 m", line(6)},
           {"estimator", "jiont", line(7)},
           {"points", "7.5", line(8)},
           {"robust", "yes", line(9)},
           {"orders", "5-1", line(10)},
           {"orders", "1-2000000000", line(11)},
           {"orders", "one", line(12)},
           {"zzz", "1", line(13)}},
          "method m", problems);
  const std::string all = "rate, soak, start, ratio, orders, estimator, robust, points, note";
  const std::vector<Asked> asked{{.values = {"sok", "soak"}, .line = 3},
                                 {.values = {"2", "2", "min"}, .key = "soak", .line = 4},
                                 {.values = {"2", "2", "min"}, .pattern = "--set", .key = "soak"},
                                 {.values = {"100", "100", "Hz"}, .key = "rate", .line = 5},
                                 {.values = {"100 m", "m", "Hz", "1/s"}, .key = "rate", .line = 6},
                                 {.values = {"jiont", "joint, two_stage", "joint"}, .key = "estimator", .line = 7},
                                 {.values = {"7.5"}, .key = "points", .line = 8},
                                 {.values = {"yes"}, .key = "robust", .line = 9},
                                 {.values = {"5-1", "5-1"}, .key = "orders", .line = 10},
                                 {.values = {"1-2000000000"}, .key = "orders", .line = 11},
                                 {.values = {"one"}, .key = "orders", .line = 12},
                                 {.values = {"zzz", all}, .line = 13}};
  ASSERT_EQ(problems.size(), asked.size());
  for (std::size_t i = 0; i < asked.size(); ++i) {
    EXPECT_TRUE(is_problem(problems[i], asked[i])) << i;
    EXPECT_EQ(problems[i].where.table, "method m") << i;
  }
}

}  // namespace
}  // namespace tumble
