#include "tumble/units/text_parts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace tumble {
namespace {

TEST(TextParts, TextsAreJoinedWithASeparatorBetweenEachTwo) {
  EXPECT_EQ(joined(std::vector<std::string>{"a", "", "b"}), "a, , b");
  EXPECT_EQ(joined(std::vector<std::string>{"", "b"}, ";"), ";b");
  EXPECT_EQ(joined(std::vector<std::string>{"a"}, ";"), "a");
  EXPECT_EQ(joined({}), "");
}

TEST(TextParts, ATextIsTrimmedAtBothEndsAndKeepsBlanksInside) {
  EXPECT_EQ(trimmed(" \ta b\t "), "a b");
  EXPECT_EQ(trimmed("a"), "a");
  EXPECT_EQ(trimmed(" \t "), "");
  EXPECT_EQ(trimmed(""), "");
}

TEST(TextParts, ATextIsTrimmedOfTheBlanksThatAreGiven) {
  EXPECT_EQ(trimmed(" \ra\n", " "), "\ra\n");
  EXPECT_EQ(trimmed(" \ra\n", " \t\r\n"), "a");
}

TEST(TextParts, TrimmedPointsIntoTheText) {
  const std::string text = "  ab ", blank = "   ";
  EXPECT_EQ(trimmed(text).data(), text.data() + 2);
  EXPECT_EQ(trimmed(blank).data(), blank.data() + 3);
}

using List = std::vector<std::string>;

TEST(TextParts, ListsAreCutAtTheirSeparators) {
  EXPECT_EQ(list_items("a, b c ,d"), (List{"a", "b c", "d"}));
  EXPECT_EQ(list_items("a,"), (List{"a", ""}));
  EXPECT_EQ(list_items(""), List{""});
  EXPECT_EQ(list_items("scrypt:8:1", ':'), (List{"scrypt", "8", "1"}));
}

TEST(TextParts, AKeyEndsAtTheFirstMark) {
  EXPECT_EQ(key_and_value("key=a=b"), (std::pair<std::string, std::string>("key", "a=b")));
  EXPECT_EQ(key_and_value("=b"), (std::pair<std::string, std::string>("", "b")));
  EXPECT_EQ(key_and_value("triad/0173", '/'), (std::pair<std::string, std::string>("triad", "0173")));
  EXPECT_FALSE(key_and_value("key"));
}

TEST(TextParts, ANumberIsTheWholeText) {
  EXPECT_EQ(as_number<int>("-12"), -12);
  EXPECT_EQ(as_number<double>("1e-3"), 1e-3);
  EXPECT_EQ(as_number<std::uint64_t>("18446744073709551615"), 18446744073709551615u);
  for (const char* text : {"", "12 ", "+12", "12a", "0x1", "18446744073709551616"})
    EXPECT_FALSE(as_number<std::uint64_t>(text)) << text;
}

TEST(TextParts, BlanksAndDigits) {
  EXPECT_EQ(trimmed(" \ta b\r\n"), "a b");
  EXPECT_EQ(trimmed(" \t"), "");
  EXPECT_TRUE(is_blank("\r\n") && is_blank("") && !is_blank(" x"));
  EXPECT_TRUE(is_digits("007") && !is_digits("") && !is_digits("1a") && !is_digits("-1"));
  EXPECT_TRUE(is_hex("09af") && !is_hex("0g") && !is_hex("0A"));
  EXPECT_EQ(first_digits("0123456789abcdef"), "0123456789ab");
  EXPECT_EQ(first_digits("0123", 16), "0123");
}

TEST(TextParts, RoundedNumbersAreTheDoublesOfTheirDecimals) {
  EXPECT_EQ(rounded_to_digits(1.23456789e-5, 3), 1.23e-5);
  EXPECT_EQ(rounded_to_digits(-99999.6, 5), -1e5);
  EXPECT_EQ(rounded_to_digits(3.15 * std::pow(10.0, -3), 3), 3.15e-3);
  EXPECT_EQ(rounded_to_digits(0.0, 3), 0.0);
  EXPECT_TRUE(std::isnan(rounded_to_digits(NAN, 3)));
}

}  // namespace
}  // namespace tumble
