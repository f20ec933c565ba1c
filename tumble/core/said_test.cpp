#include "tumble/core/said.hpp"

#include <gtest/gtest.h>

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

TEST(Said, BracesInAValueAreKept) { EXPECT_EQ(chinese("wrote {0}.h5"), "已写入 {0}.h5"); }

}  // namespace
}  // namespace tumble
