#include "tumble/core/option.hpp"

#include <gtest/gtest.h>

#include "tumble/core/settings.hpp"
#include "tumble/language/said.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// Problem of one option given as this text, or empty.
std::string problem_of(const Option& option, const std::string& text, bool command_line = false) {
  Problems problems;
  resolve({option}, {{option.name, text, "plan.toml:3", true, command_line}}, "method", problems);
  EXPECT_LE(problems.size(), 1u);
  return problems.empty() ? "" : problems.front().text();
}

TEST(Option, BuilderSaysWhatIsAccepted) {
  const Option option = quantity("level_sd", "%").at_least(0).otherwise("1 %").bare().says("uncertainty of the level");
  EXPECT_EQ(option.name, "level_sd");
  EXPECT_EQ(option.type, Option::Type::quantity);
  EXPECT_EQ(option.unit, "%");
  EXPECT_EQ(option.fallback, "1 %");
  EXPECT_EQ(option.description, "uncertainty of the level");
  EXPECT_TRUE(option.bare_on_command_line);
  EXPECT_EQ(word("from", {"plan", "data"}).words, (std::vector<std::string>{"plan", "data"}));
  EXPECT_EQ(flag("all").fallback, "false");
  EXPECT_EQ(integer("n").type, Option::Type::integer);
  EXPECT_EQ(integers("n").type, Option::Type::integers);
  EXPECT_EQ(text("n").type, Option::Type::text);
}

TEST(Option, RangeIsNamedInItsUnit) {
  const auto named = [](const Option& option) { return name(option.range, option.unit); };
  EXPECT_EQ(named(quantity("x", "g").above(0)), "above 0 g");
  EXPECT_EQ(named(quantity("x", "g").at_least(0.5)), "at least 0.5 g");
  EXPECT_EQ(named(quantity("x", "g").below(3)), "below 3 g");
  EXPECT_EQ(named(quantity("x", "g").at_most(3)), "at most 3 g");
  EXPECT_EQ(named(quantity("x", "g").between(-1, 3)), "between -1 and 3 g");
  EXPECT_EQ(named(quantity("x", "g").above(0).at_most(3)), "above 0 g and at most 3 g");
  EXPECT_EQ(named(quantity("x").at_least(0).below(1)), "at least 0 and below 1");
  EXPECT_EQ(named(quantity("x")), "");
}

TEST(Option, RangeIsSaidInChinese) {
  const auto said = [](const Option& option) {
    return in_language(Language::chinese, said_of(option.range, option.unit));
  };
  EXPECT_EQ(said(quantity("x", "g").above(0).at_most(3)), "大于 0 g 且不大于 3 g");
  EXPECT_EQ(said(quantity("x", "g").between(-1, 3)), "在 -1～3 g 之内");
  Problems problems;
  resolve({quantity("x", "g").above(0)}, {{"x", "0 g", "plan.toml:3", true, false}}, say("{}", Name{"method"}),
          problems);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_TRUE(in_language(Language::chinese, problems[0]).ends_with("“0 g”：取值应大于 0 g"))
      << in_language(Language::chinese, problems[0]);
}

TEST(Option, EndsOfTheRangeBelongToItUnlessOpen) {
  const auto accepts = [](const Option& option, const char* value) { return problem_of(option, value).empty(); };
  EXPECT_FALSE(accepts(quantity("x", "g").above(0), "0 g"));
  EXPECT_TRUE(accepts(quantity("x", "g").above(0), "1e-300 g"));
  EXPECT_TRUE(accepts(quantity("x", "g").at_least(0), "0 g"));
  EXPECT_FALSE(accepts(quantity("x", "g").at_least(0), "-1e-300 g"));
  EXPECT_FALSE(accepts(quantity("x", "g").below(2), "2 g"));
  EXPECT_TRUE(accepts(quantity("x", "g").below(2), "1.999999 g"));
  EXPECT_TRUE(accepts(quantity("x", "g").at_most(2), "2 g"));
  EXPECT_FALSE(accepts(quantity("x", "g").at_most(2), "2.000001 g"));
  EXPECT_TRUE(accepts(integer("n").between(1, 8), "1"));
  EXPECT_TRUE(accepts(integer("n").between(1, 8), "8"));
  EXPECT_FALSE(accepts(integer("n").between(1, 8), "0"));
  EXPECT_FALSE(accepts(integer("n").between(1, 8), "9"));
}

TEST(Option, RefusalSaysWhatWhereAndTheRange) {
  const auto problem = [](const Option& option, const char* text) {
    Problems problems;
    const Where line{.file = "plan.toml", .line = 3, .place = say("{}:{}", Name{"plan.toml"}, 3)};
    resolve({option}, {{option.name, text, line}}, "method", problems);
    return problems.size() == 1 ? problems.front() : Problem();
  };
  EXPECT_TRUE(is_problem(problem(quantity("settling", "s").at_least(0), "-2 s"),
                         {.values = {"-2 s", "0 s"}, .table = "method", .key = "settling", .line = 3}));
  EXPECT_TRUE(is_problem(problem(integer("terms").between(1, 8), "9"),
                         {.values = {"9", "1", "8"}, .table = "method", .key = "terms", .line = 3}));
}

// A limit in one unit, a value in another: the last digits of the conversion are forgiven at a closed end.
TEST(Option, RoundingOfAConversionIsForgiven) {
  EXPECT_EQ(problem_of(quantity("t", "s").at_most(0.02), "20 ms"), "");
  EXPECT_EQ(problem_of(quantity("t", "ms").between(20, 20), "0.02 s"), "");
  EXPECT_EQ(problem_of(quantity("a", "deg").at_most(180), "3.141592653589793 rad"), "");
  EXPECT_EQ(problem_of(quantity("f", "Hz").at_least(0.1), "100 mHz"), "");
  EXPECT_NE(problem_of(quantity("t", "s").at_most(0.02), "20.0001 ms"), "");
}

TEST(Option, OtherUnitsOfTheDimensionAreAccepted) {
  EXPECT_EQ(problem_of(quantity("T", "degC").above(-273.15), "1 K"), "");
  EXPECT_NE(problem_of(quantity("T", "degC").above(-273.15), "0 K"), "");
}

TEST(Option, EachOfSeveralIntegersLiesInTheRange) {
  const Option orders = integers("orders").between(1, 8);
  EXPECT_EQ(problem_of(orders, "1,3-5,8"), "");
  EXPECT_NE(problem_of(orders, "1,3-9"), "");
  EXPECT_NE(problem_of(orders, "0,3"), "");
}

TEST(Option, NumbersAreFinite) {
  for (const char* value : {"nan s", "inf s", "-inf s", "1e999 s"})
    EXPECT_NE(problem_of(quantity("t", "s"), value), "") << value;
}

TEST(Option, BareNumberOnTheCommandLineHasTheRangeToo) {
  const Option rate = quantity("rate", "Hz").above(0).bare();
  EXPECT_EQ(problem_of(rate, "100", true), "");
  EXPECT_NE(problem_of(rate, "0", true), "");
  EXPECT_NE(problem_of(rate, "100"), "");
}

}  // namespace
}  // namespace tumble
