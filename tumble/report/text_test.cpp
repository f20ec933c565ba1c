#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tumble/report/report.hpp"
#include "tumble/report/testing/example_estimate.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/report/utf8.hpp"

namespace tumble {
namespace {

using Align = TextColumn::Align;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(text_report, says_everything_that_a_reader_needs) {
  const auto text = to_text(testing::estimate());
  for (const std::string part :
       {"Thermal bias of a fibre-optic gyro, eight start temperatures\n", "serial FOG-0117", "0.451 ± 0.018",
        "[0.394, 0.509]", "turn-on", "99 %", "<1 %", "Fit: 460800 observations, 460789 degrees of freedom",
        "(1.00 per degree of freedom)", "Table models", "44 rows", "UNDECIDED  input_axis_misalignment"}) {
    EXPECT_TRUE(has(text, part)) << part << "\nin\n" << text;
  }
}

TEST(text_report, no_line_is_wider_than_a_hundred_columns) {
  std::istringstream lines(to_text(testing::estimate()));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(display_width(line), 100u) << line;
}

TEST(text_report, the_worst_finding_comes_first) {
  const auto text = to_text(testing::estimate());
  EXPECT_LT(text.find("  error "), text.find("  warning "));
  EXPECT_LT(text.find("  warning "), text.find("  info "));
}

TEST(text_report, foreign_text_cannot_steer_the_terminal) {
  auto estimate = testing::estimate();
  estimate.title = "a\x1b[2Jb\nc";
  estimate.tables[2].rows[0][1] = std::string("\x1b]0;x\x07");
  const auto text = to_text(estimate);
  EXPECT_TRUE(has(text, "a [2Jb c\n"));
  EXPECT_FALSE(has(text, "\x1b"));
}

TEST(text_report, an_empty_estimate_is_only_a_heading) {
  Estimate estimate;
  estimate.method = "static_bias";
  EXPECT_EQ(to_text(estimate), "static_bias\n");
}

TEST(text_table, lines_up_wide_and_combining_characters) {
  const auto text = text_table({{"a", "", {"陀螺", "e\u0301", "abcd"}, Align::left}, {"b", "", {"1", "2", "3"}}});
  EXPECT_EQ(text,
            "  a     b\n"
            "  ───────\n"
            "  陀螺  1\n"
            "  e\u0301     2\n"
            "  abcd  3\n");
}

TEST(text_table, continues_below_with_the_first_column_repeated) {
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

TEST(wrapped, breaks_at_blanks_and_keeps_long_words) {
  EXPECT_EQ(wrapped("- ", "aa bb cc", 7), "- aa bb\n  cc\n");
  EXPECT_EQ(wrapped("", "aaaaaaaaaa b", 4), "aaaaaaaaaa\nb\n");
  EXPECT_EQ(wrapped("x: ", "", 4), "x: \n");
}

TEST(printable, replaces_what_is_no_text) {
  EXPECT_EQ(printable("δ_o ok"), "δ_o ok");
  EXPECT_EQ(printable("a\xC0\xAF"
                      "b"),
            "a\uFFFD\uFFFDb");                                 // overlong form
  EXPECT_EQ(printable("\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD");  // surrogate
  EXPECT_EQ(printable("\xE2\x82"), "\uFFFD\uFFFD");            // cut off
  EXPECT_EQ(printable("a\u202Eb"), "a b");                     // would turn the direction of writing
}

}  // namespace
}  // namespace tumble
