#include "tumble/units/plain_text.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace tumble {
namespace {

TEST(PlainText, IsJoinedWithASeparatorBetweenEachTwo) {
  EXPECT_EQ(joined(std::vector<std::string>{"a", "", "b"}), "a, , b");
  EXPECT_EQ(joined(std::vector<std::string>{"", "b"}, ";"), ";b");
  EXPECT_EQ(joined(std::vector<std::string>{"a"}, ";"), "a");
  EXPECT_EQ(joined({}), "");
}

TEST(PlainText, IsTrimmedAtBothEndsAndKeepsBlanksInside) {
  EXPECT_EQ(trimmed(" \ta b\t "), "a b");
  EXPECT_EQ(trimmed("a"), "a");
  EXPECT_EQ(trimmed(" \t "), "");
  EXPECT_EQ(trimmed(""), "");
}

TEST(PlainText, IsTrimmedOfTheBlanksThatAreGiven) {
  EXPECT_EQ(trimmed(" \ra\n", " "), "\ra\n");
  EXPECT_EQ(trimmed(" \ra\n", " \t\r\n"), "a");
}

TEST(PlainText, TrimmedPointsIntoTheText) {
  const std::string text = "  ab ", blank = "   ";
  EXPECT_EQ(trimmed(text).data(), text.data() + 2);
  EXPECT_EQ(trimmed(blank).data(), blank.data() + 3);
}

}  // namespace
}  // namespace tumble
