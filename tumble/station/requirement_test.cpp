#include "tumble/station/requirement.hpp"

#include <gtest/gtest.h>

#include <map>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

const std::map<std::string, ChannelReading> known_channels{{"chamber.temperature", 350.0},
                                                           {"arm.rate", -0.001},
                                                           {"input.door", std::string("closed")},
                                                           {"unit.status", std::string("ok")},
                                                           {"input.count", 0.0}};

Holds holds_now(const std::string& text) {
  return evaluate(parse_requirement(text), [](const std::string& channel) {
    const auto found = known_channels.find(channel);
    return found == known_channels.end() ? ChannelReading() : found->second;
  });
}

TEST(Requirement, ComparesQuantitiesInTheirUnits) {
  EXPECT_EQ(holds_now("chamber.temperature < 76.86 degC"), Holds::yes);  // 350 K are 76.85 degC
  EXPECT_EQ(holds_now("chamber.temperature < 76.84 degC"), Holds::no);
  EXPECT_EQ(holds_now("chamber.temperature >= 350 K"), Holds::yes);
  EXPECT_EQ(holds_now("arm.rate >= 0 deg/s"), Holds::no);
  EXPECT_EQ(holds_now("abs(arm.rate) <= 0.06 deg/s"), Holds::yes);  // 0.001 rad/s are 0.0573 deg/s
  EXPECT_EQ(holds_now("abs(arm.rate) > 0.06 (deg)/s"), Holds::no);
}

TEST(Requirement, ComparesWords) {
  EXPECT_EQ(holds_now("input.door == closed"), Holds::yes);
  EXPECT_EQ(holds_now("input.door != closed"), Holds::no);
  EXPECT_EQ(holds_now("unit.status"), Holds::yes);
  EXPECT_EQ(holds_now("not input.count"), Holds::yes);
}

TEST(Requirement, AndBindsStrongerThanOr) {
  EXPECT_EQ(holds_now("unit.status or unit.status and input.count"), Holds::yes);
  EXPECT_EQ(holds_now("(unit.status or unit.status) and input.count"), Holds::no);
  EXPECT_EQ(holds_now("(arm.rate < 1 deg/s and input.door == open) or unit.status"), Holds::yes);
}

TEST(Requirement, IsUnknownOnlyWhereTheUnknownPartDecides) {
  EXPECT_EQ(holds_now("nobody.knows"), Holds::unknown);
  EXPECT_EQ(holds_now("nobody.knows or unit.status"), Holds::yes);
  EXPECT_EQ(holds_now("nobody.knows and input.count"), Holds::no);
  EXPECT_EQ(holds_now("not nobody.knows"), Holds::unknown);
  EXPECT_EQ(holds_now("input.door < 1"), Holds::unknown);  // a word where a number is expected
}

TEST(Requirement, SaysWhereItCannotBeRead) {
  const std::pair<const char*, const char*> all[] = {// with the character at which the reading stops
                                                     {"", "1"},
                                                     {"and", "1"},
                                                     {"arm.rate <", "11"},
                                                     {"arm.rate < fast", "12"},
                                                     {"(a", "3"},
                                                     {"a b", "3"},
                                                     {"abs(a)", "7"},
                                                     {"a or", "5"},
                                                     {"not", "4"},
                                                     {"abs(a) == closed", "11"},
                                                     {"a == 1 deg) and b", "11"},
                                                     {"input.door == closed but why", "22"}};
  for (const auto& [bad, character] : all)
    EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {bad, character}}, [&, text = bad] {
      parse_requirement(text);
    })) << bad;
  const std::pair<const char*, const char*> quantities[] = {{"arm.rate < 1 m", "1 m"},
                                                            {"chamber.temperature < 90", "90"}};
  for (const auto& [bad, quantity] : quantities)
    EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {quantity}}, [&, text = bad] {
      parse_requirement(text);
    })) << bad;
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "nested too deeply"},
                      [&] { parse_requirement(std::string(100'000, '(')); }));
}

}  // namespace
}  // namespace tumble
