#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tumble/report/report.hpp"
#include "tumble/report/testing/example_estimate.hpp"
#include "tumble/report/testing/text_parts.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/report/utf8.hpp"

namespace tumble {
namespace {

using Align = TextColumn::Align;

TEST(TextReport, SaysEverythingThatAReaderNeeds) {
  const auto text = to_text(testing::estimate());
  for (const std::string part :
       {"Thermal bias of a fibre-optic gyro, eight start temperatures\n", "serial FOG-0117", "0.451 ± 0.018",
        "[0.394, 0.509]", "turn-on", "99 %", "<1 %", "Fit: 460800 observations, 460789 degrees of freedom",
        "(1.00 per degree of freedom)", "Table models", "44 rows", "UNDECIDED  input_axis_misalignment"}) {
    EXPECT_TRUE(has(text, part)) << part << "\nin\n" << text;
  }
}

TEST(TextReport, NoLineIsWiderThanAHundredColumns) {
  std::istringstream lines(to_text(testing::estimate()));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(display_width(line), 100u) << line;
}

TEST(TextReport, TheWorstFindingComesFirst) {
  const auto text = to_text(testing::estimate());
  EXPECT_LT(text.find("  error "), text.find("  warning "));
  EXPECT_LT(text.find("  warning "), text.find("  info "));
}

TEST(TextReport, ForeignTextCannotSteerTheTerminal) {
  auto estimate = testing::estimate();
  estimate.title = "a\x1b[2Jb\nc";
  estimate.tables[2].rows[0][1] = std::string("\x1b]0;x\x07");
  const auto text = to_text(estimate);
  EXPECT_TRUE(has(text, "a [2Jb c\n"));
  EXPECT_FALSE(has(text, "\x1b"));
}

TEST(TextReport, AnEmptyEstimateIsOnlyAHeading) {
  Estimate estimate;
  estimate.method = "static_bias";
  EXPECT_EQ(to_text(estimate), "static_bias\n");
}

TEST(TextTable, LinesUpWideAndCombiningCharacters) {
  const auto text = text_table({{"a", "", {"陀螺", "e\u0301", "abcd"}, Align::left}, {"b", "", {"1", "2", "3"}}});
  EXPECT_EQ(text,
            "  a     b\n"
            "  ───────\n"
            "  陀螺  1\n"
            "  e\u0301     2\n"
            "  abcd  3\n");
}

TEST(TextTable, ContinuesBelowWithTheFirstColumnRepeated) {
  const auto text =
      text_table({{"k", "", {"x"}, Align::left}, {"aaaaaaaaaa", "", {"1"}}, {"bbbbbbbbbb", "", {"2"}}}, 20);
  EXPECT_EQ(text,
            "  k  aaaaaaaaaa\n"
            "  ─────────────\n"
            "  x           1\n"
            "\n"
            "  k  bbbbbbbbbb\n"
            "  ─────────────\n"
            "  x           2\n");
}

TEST(Wrapped, BreaksAtBlanksAndKeepsLongWords) {
  EXPECT_EQ(wrapped("- ", "aa bb cc", 7), "- aa bb\n  cc\n");
  EXPECT_EQ(wrapped("", "aaaaaaaaaa b", 4), "aaaaaaaaaa\nb\n");
  EXPECT_EQ(wrapped("x: ", "", 4), "x: \n");
}

TEST(Wrapped, BreaksBetweenHanCharactersButNotBeforeAComma) {
  EXPECT_EQ(wrapped("", "数据中断，丢失", 8), "数据中\n断，丢失\n");
  EXPECT_EQ(wrapped("  ", "在 gyro 处“中断”", 9), "  在 gyro\n  处“中\n  断”\n");
  EXPECT_EQ(breakable_parts("abc-def"), (std::vector<std::string>{"abc-def"}));
  EXPECT_EQ(breakable_parts("（95%）内"), (std::vector<std::string>{"（95%）", "内"}));
}

TEST(TextReport, InChineseHasValueAndStandardUncertaintyInColumns) {
  const auto text = to_text(testing::estimate(), 100, Language::chinese);
  for (const std::string part :
       {"测得值", "标准不确定度 u", "95% 包含区间", "诊断信息", "判定结果", "待定", "不确定度分量汇总表"})
    EXPECT_TRUE(has(text, part)) << part << "\nin\n" << text;
  EXPECT_FALSE(has(text, "±"));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(display_width(line), 100u) << line;
}

TEST(Printable, ReplacesWhatIsNoText) {
  EXPECT_EQ(printable("δ_o ok"), "δ_o ok");
  EXPECT_EQ(printable("a\xC0\xAF"
                      "b"),
            "a\uFFFD\uFFFDb");                                 // overlong form
  EXPECT_EQ(printable("\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD");  // surrogate
  EXPECT_EQ(printable("\xE2\x82"), "\uFFFD\uFFFD");            // cut off
  EXPECT_EQ(printable_lines("a\n\tb\u202Ec\033[2J"), "a\n\tb\uFFFDc\uFFFD[2J");
  EXPECT_EQ(printable("a\u202Eb"), "a b");  // would turn the direction of writing
}

}  // namespace
}  // namespace tumble
