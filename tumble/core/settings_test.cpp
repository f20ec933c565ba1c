#include "tumble/core/settings.hpp"

#include <gtest/gtest.h>

#include "tumble/units/error.hpp"

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
  EXPECT_THROW(settings.number("rate"), Error);
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
  resolve(options(),
          {{"sok", "2 h", "plan.toml:3"},
           {"soak", "2", "plan.toml:4", false},
           {"soak", "2", "--set", true, true},
           {"rate", "100", "plan.toml:5"},
           {"rate", "100 m", "plan.toml:6"},
           {"estimator", "jiont", "plan.toml:7"},
           {"points", "7.5", "plan.toml:8"},
           {"robust", "yes", "plan.toml:9"},
           {"orders", "5-1", "plan.toml:10"},
           {"orders", "1-2000000000", "plan.toml:11"},
           {"orders", "one", "plan.toml:12"},
           {"zzz", "1", "plan.toml:13"}},
          "method m", problems);
  ASSERT_EQ(problems.size(), 12u);
  EXPECT_EQ(problems[0], "plan.toml:3: method m: unknown key 'sok'; did you mean 'soak'?");
  EXPECT_EQ(problems[1], "plan.toml:4: method m: soak: '2' has no unit: write for example '2 min'");
  EXPECT_EQ(problems[2], "--set: method m: soak: '2' has no unit: write for example '2 min'");
  EXPECT_EQ(problems[4], "plan.toml:6: method m: rate: '100 m' is in m, but a quantity in Hz (1/s) is expected");
  EXPECT_EQ(problems[5],
            "plan.toml:7: method m: estimator: 'jiont': expected one of joint, two_stage; did you mean 'joint'?");
  EXPECT_EQ(problems[11],
            "plan.toml:13: method m: unknown key 'zzz'; known are rate, soak, start, ratio, orders, estimator, robust, "
            "points, note");
}

}  // namespace
}  // namespace tumble
