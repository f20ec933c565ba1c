#include "tumble/core/said.hpp"

#include <gtest/gtest.h>

#include "tumble/core/message_in.hpp"

namespace tumble {
namespace {

std::string chinese(const std::string& english) { return said_in(Language::chinese, english); }

TEST(Said, EnglishIsUnchanged) { EXPECT_EQ(said_in(Language::english, "cannot read 'x': y"), "cannot read 'x': y"); }

TEST(Said, AValueIsKeptAndASentenceInItIsTranslated) {
  EXPECT_EQ(chinese("cannot read 'a b.csv': No such file or directory"), "无法读取“a b.csv”：没有该文件或文件夹");
  EXPECT_EQ(chinese("cannot read 'x': Stale file handle"), "无法读取“x”：Stale file handle");
}

TEST(Said, WhatStandsBeforeASentenceIsKept) {
  EXPECT_EQ(chinese("plan.toml:7: unknown key 'titel'; did you mean 'title'?"),
            "plan.toml:7：无法识别的键“titel”，是否应为“title”？");
  EXPECT_EQ(chinese("plan.toml:7: rig rate_table: must be above zero"), "plan.toml:7：测试设备 rate_table：应大于零");
}

TEST(Said, ThePatternWithTheMostLettersIsTaken) {
  EXPECT_EQ(chinese("wrote a.h5 (seed 3)"), "已写入 a.h5（随机种子 3）");
  EXPECT_EQ(chinese("wrote a.h5"), "已写入 a.h5");
}

TEST(Said, ASentenceWithoutAPatternStaysEnglish) {
  EXPECT_EQ(chinese("colourless ideas: sleep"), "colourless ideas: sleep");
  EXPECT_EQ(chinese(""), "");
  EXPECT_EQ(chinese("{} {0}"), "{} {0}");
}

TEST(Said, LinesAreTranslatedOneByOne) {
  EXPECT_EQ(chinese("\nno question is open\n  reading\nx\n"), "\n没有待回答的问题\n  正在读取\nx\n");
}

TEST(Said, AFindingThatIsTheReasonOfARefusalIsTranslated) {
  const Finding finding(Finding::Severity::error, "frames_uncertain", {{"declaration", "imu_x"}});
  EXPECT_EQ(chinese("x.raw: " + finding.message), "x.raw：" + message_in(Language::chinese, finding));
}

std::string result(const std::string& english) {
  return result_words_in(Language::chinese, english).value_or("nothing");
}

TEST(ResultWords, AreNoneInEnglish) { EXPECT_EQ(result_words_in(Language::english, "output noise"), std::nullopt); }

TEST(ResultWords, AValueOfOneWordIsTranslatedAndANameIsKept) {
  EXPECT_EQ(result("wobble of inner once per turn, cosine"), "内轴轴系晃动一次谐波（余弦）");
  EXPECT_EQ(result("output noise of gyro_x"), "gyro_x 输出噪声");
  EXPECT_EQ(result("gain over frequency"), "增益随频率的变化");
}

TEST(ResultWords, ABlankStandsBesideLatinLettersAlone) {
  EXPECT_EQ(result("index zero of arm"), "转臂零位");
  EXPECT_EQ(result("index zero of C"), "C 零位");
}

TEST(ResultWords, NamesAreFoundWithBlanksAndWithUnderscores) {
  EXPECT_EQ(result("gyro_x_scale_factor_error"), "gyro_x 标度因数误差");
  EXPECT_EQ(result("gyro x scale factor error"), "gyro x 标度因数误差");
  EXPECT_EQ(result("whole_minus_split.gyro_x_bias"), "整机减单通道：gyro_x 零偏");
}

TEST(ResultWords, BothHalvesOfADescriptionAreTranslatedOrNone) {
  EXPECT_EQ(result("drift per f_S (mass offset along I); means D_S + 2 D_SS"),
            "与 f_S 成比例的漂移（沿 I 的质量偏心）；代表 D_S + 2 D_SS");
  EXPECT_EQ(result("output noise; and colourless ideas"), "nothing");
}

TEST(ResultWords, AShortPatternIsNotTakenForAnythingBetweenTwoWords) {
  EXPECT_EQ(result("0.6 to 6 deg/h"), "0.6～6 deg/h");
  EXPECT_EQ(result("colourless ideas over sleep"), "nothing");
}

TEST(Said, BracesInAValueAreKept) { EXPECT_EQ(chinese("wrote {0}.h5"), "已写入 {0}.h5"); }

}  // namespace
}  // namespace tumble
