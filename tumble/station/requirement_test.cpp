#include "tumble/station/requirement.hpp"

#include <gtest/gtest.h>

#include <map>

#include "tumble/units/error.hpp"

namespace tumble {
namespace {

const std::map<std::string, ChannelReading> readings{{"chamber.temperature", 350.0},
                                                     {"arm.rate", -0.001},
                                                     {"input.door", std::string("closed")},
                                                     {"unit.status", std::string("ok")},
                                                     {"input.count", 0.0}};

Holds asked(const std::string& text) {
  return evaluate(parse_requirement(text), [](const std::string& channel) {
    const auto found = readings.find(channel);
    return found == readings.end() ? ChannelReading() : found->second;
  });
}

TEST(Requirement, ComparesQuantitiesInTheirUnits) {
  EXPECT_EQ(asked("chamber.temperature < 76.86 degC"), Holds::yes);  // 350 K are 76.85 degC
  EXPECT_EQ(asked("chamber.temperature < 76.84 degC"), Holds::no);
  EXPECT_EQ(asked("chamber.temperature >= 350 K"), Holds::yes);
  EXPECT_EQ(asked("arm.rate >= 0 deg/s"), Holds::no);
  EXPECT_EQ(asked("abs(arm.rate) <= 0.06 deg/s"), Holds::yes);  // 0.001 rad/s are 0.0573 deg/s
  EXPECT_EQ(asked("abs(arm.rate) > 0.06 (deg)/s"), Holds::no);
}

TEST(Requirement, ComparesWords) {
  EXPECT_EQ(asked("input.door == closed"), Holds::yes);
  EXPECT_EQ(asked("input.door != closed"), Holds::no);
  EXPECT_EQ(asked("unit.status"), Holds::yes);
  EXPECT_EQ(asked("not input.count"), Holds::yes);
}

TEST(Requirement, AndBindsStrongerThanOr) {
  EXPECT_EQ(asked("unit.status or unit.status and input.count"), Holds::yes);
  EXPECT_EQ(asked("(unit.status or unit.status) and input.count"), Holds::no);
  EXPECT_EQ(asked("(arm.rate < 1 deg/s and input.door == open) or unit.status"), Holds::yes);
}

TEST(Requirement, IsUnknownOnlyWhereTheUnknownPartDecides) {
  EXPECT_EQ(asked("nobody.knows"), Holds::unknown);
  EXPECT_EQ(asked("nobody.knows or unit.status"), Holds::yes);
  EXPECT_EQ(asked("nobody.knows and input.count"), Holds::no);
  EXPECT_EQ(asked("not nobody.knows"), Holds::unknown);
  EXPECT_EQ(asked("input.door < 1"), Holds::unknown);  // a word where a number is expected
}

TEST(Requirement, SaysWhereItCannotBeRead) {
  for (const char* bad : {"", "and", "arm.rate <", "arm.rate < fast", "arm.rate < 1 m", "(a", "a b", "abs(a)", "a or",
                          "chamber.temperature < 90", "not", "abs(a) == closed", "a == 1 deg) and b"})
    EXPECT_THROW(parse_requirement(bad), Error) << bad;
  try {
    parse_requirement("input.door == closed but why");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.problems.front(),
              "'input.door == closed but why': at character 22: 'and', 'or' or the end is expected");
  }
  EXPECT_THROW(parse_requirement(std::string(100'000, '(')), Error);
}

}  // namespace
}  // namespace tumble
