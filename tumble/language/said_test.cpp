#include "tumble/language/said.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cerrno>

#include "tumble/language/say.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

std::string chinese(const Problem& problem) { return in_language(Language::chinese, problem); }

std::string chinese_of_stored(const std::string& english) { return said_in(Language::chinese, english); }

const Name tricky_names[] = {
    {"rig 3.csv"}, {"line 2.csv"}, {"model B.csv"}, {"limits of unit 4.csv"}, {"below 20 degC.csv"}};

TEST(Said, EnglishIsUnchanged) {
  EXPECT_EQ(in_language(Language::english, say("cannot read '{}': {}", Name{"x"}, "y")), "cannot read 'x': y");
  EXPECT_EQ(said_in(Language::english, "cannot read 'x': y"), "cannot read 'x': y");
}

TEST(Said, ANameIsNeverTranslated) {
  for (const Name& name : tricky_names) {
    EXPECT_EQ(chinese(say("cannot read '{}': {}", name, "No such file or directory")),
              "无法读取“" + name.text + "”：没有该文件或文件夹");
    EXPECT_EQ(chinese(say("wrote {}", name)), "已写入 " + name.text);
    EXPECT_EQ(chinese(within(say("{}", name), Problem("true or false is expected"))),
              name.text + "：应为 true 或 false");
    EXPECT_EQ(chinese_of_stored("wrote " + name.text), "已写入 " + name.text);
  }
}

TEST(Said, WhatCannotBeTranslatedWholeIsEnglishWhole) {
  EXPECT_EQ(chinese(say("cannot read '{}': {}", Name{"x"}, "colourless ideas")), "cannot read 'x': colourless ideas");
  EXPECT_EQ(chinese(say("cannot read '{}': {}", Name{"x"}, Sentence(std::string("ideas sleep")))),
            "cannot read 'x': ideas sleep");
  EXPECT_EQ(chinese(within("colourless ideas", Problem("true or false is expected"))),
            "colourless ideas: true or false is expected");
  EXPECT_EQ(chinese("colourless ideas: sleep"), "colourless ideas: sleep");
  EXPECT_EQ(chinese(""), "");
}

TEST(Said, ASentenceInASentenceIsTranslated) {
  EXPECT_EQ(chinese(say("unknown key '{}'{}", std::string("titel"), say("; did you mean '{}'?", std::string("title")))),
            "无法识别的键“titel”，是否应为“title”？");
  EXPECT_EQ(chinese(within(say("line {}, column {} '{}'", 3, 2, Name{"gyro"}), say("'{}' is not a number", "x"))),
            "第 3 行第 2 列“gyro”：“x”不是数值");
  EXPECT_EQ(chinese(within(say("line {}", 3), say("{} cells instead of {}", 3, 2))),
            "第 3 行：有 3 个单元格，应为 2 个");
}

TEST(Said, TheReasonThatTheSystemGivesIsTranslated) {
  for (const auto& [english, translation] :
       {std::pair("Not a directory", "不是文件夹"), {"Permission denied", "没有权限"}})
    EXPECT_EQ(chinese(say("cannot write '{}': {}", Name{"a b.csv"}, system_reason(english))),
              "无法写入“a b.csv”：" + std::string(translation));
}

TEST(Said, ANameThatIsASentenceOfATableStaysAsItIs) {
  EXPECT_EQ(chinese(say("wrote {}", Name{"Is a directory"})), "已写入 Is a directory");
  EXPECT_EQ(chinese(say("cannot read '{}': {}", std::string("File exists"), system_reason(ENOENT))),
            "无法读取“File exists”：没有该文件或文件夹");
}

TEST(Said, ATextInQuotesIsAName) {
  const Sentence said = say("wrote '{}'", std::string("File exists"));
  EXPECT_EQ(said.values.at(0).kind, SentenceValue::Kind::name);
}

TEST(Said, WhatALibrarySaysIsItsPatternAndItsValues) {
  EXPECT_EQ(chinese(said_by_library("RECORDING is required")), "缺少 RECORDING");
  EXPECT_EQ(said_by_library("no such key").text(), "no such key");
}

TEST(Said, SentencesInARowAreTranslatedEach) {
  const Sentence all = in_a_row({say("{} messages", 60), say("{}", Name{"x"})}, ", ");
  EXPECT_EQ(all.text(), "60 messages, x");
  EXPECT_EQ(chinese(say("wrote {}", all)), "已写入 60 条消息、x");
}

TEST(Said, AListOfNamesHasTheMarksOfTheLanguage) {
  const std::vector<std::string> names{"a", "b, c"};
  const Sentence said = say("no column '{}' for time{}; columns are {}", "x", Sentence(), fmt::join(names, ", "));
  EXPECT_EQ(said.text(), "no column 'x' for time; columns are a, b, c");
  EXPECT_EQ(chinese(said), "没有作为时间的列“x”。已有的列：a、b, c") << "a comma in a name stays";
}

TEST(Said, TheReasonOfSeveralProblemsIsTheirRow) {
  const Error error(Error::Kind::bad_file, Problems{"No such file or directory", "Permission denied"});
  const Sentence said = say("cannot read '{}': {}", Name{"x"}, reason_of(error));
  EXPECT_EQ(said.text(), "cannot read 'x': No such file or directory; Permission denied");
  EXPECT_EQ(chinese(said), "无法读取“x”：没有该文件或文件夹；没有权限");
}

TEST(Said, APlaceHasTheQuotesOfTheLanguage) {
  EXPECT_EQ(chinese(within(say("[[frame]] '{}'", Name{"sample"}), Problem("true or false is expected"))),
            "[[frame]] “sample”：应为 true 或 false");
}

TEST(Said, AFullStopBehindAQuestionMarkGoes) {
  EXPECT_EQ(chinese(say("no column '{}' for time{}; columns are {}", std::string("x"),
                        say("; did you mean '{}'?", std::string("y")), Name{"y"})),
            "没有作为时间的列“x”，是否应为“y”？已有的列：y");
}

TEST(Said, LinesAreTranslatedOneByOne) {
  EXPECT_EQ(chinese_of_stored("\nno question is open\n  reading\nx\n"), "\n没有待回答的问题\n  正在读取\nx\n");
  EXPECT_EQ(chinese(say("\nwrote {}\n  wrote {}\nx y\n", Name{"a"}, Name{"b"})), "\n已写入 a\n  已写入 b\nx y\n");
}

std::string result(const std::string& english) {
  return result_words_in(Language::chinese, english).value_or("nothing");
}

TEST(Said, ACountOfARefusalLosesItsNoun) {
  const Sentence few = say("'{}' has {}: too few for a vibration test", Name{"a"}, said_count(5, "sample"));
  EXPECT_EQ(few.text(), "'a' has 5 samples: too few for a vibration test");
  EXPECT_EQ(chinese(few), "“a”只有 5 个采样点：不足以作振动试验");
  const Sentence back =
      say("'{}': {} not later than the one before: such a clock does not determine counting windows; "
          "write the stamps with more digits, or omit them and give the rate (--set rate=200)",
          Name{"a"}, said_count(1, "stamp"));
  EXPECT_TRUE(chinese(back).starts_with("“a”：有 1 个时标不晚于前一个")) << chinese(back);
}

TEST(Said, AWordOfTheProgramInQuotesIsAName) {
  const char* const name = "kind";
  EXPECT_EQ(chinese(say("'{}' must be a text", name)), "“kind”应为文本");
}

TEST(Said, AProblemInASentenceIsTranslatedWithItsPlace) {
  const Problem problem = within(say("{}:{}", Name{"p.toml"}, 7), Problem("true or false is expected"));
  EXPECT_EQ(chinese(say("cannot read '{}': {}", Name{"x"}, problem)), "无法读取“x”：p.toml:7：应为 true 或 false");
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

TEST(Said, BracesInAValueAreKept) { EXPECT_EQ(chinese(say("wrote {}", Name{"{0}.h5"})), "已写入 {0}.h5"); }

}  // namespace
}  // namespace tumble
