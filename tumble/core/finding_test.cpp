#include "tumble/core/finding.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/core/message_in.hpp"
#include "tumble/language/said.hpp"
#include "tumble/language/text.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using Severity = Finding::Severity;

Finding with(std::vector<FindingValue> values, Occurrences occurrences = {}) {
  Finding finding;
  finding.code = "test";
  finding.values = std::move(values);
  finding.occurrences = std::move(occurrences);
  return finding;
}

double si(double value, const char* unit) { return Unit::parse(unit).to_si(value); }

TEST(Finding, IsBuiltWithItsSentence) {
  const Finding finding(Severity::error, "constant_output", {{"value", si(25.0, "deg/h"), "deg/h"}}, "gyro");
  EXPECT_EQ(finding.severity, Severity::error);
  EXPECT_EQ(finding.code, "constant_output");
  EXPECT_EQ(finding.message, "the output is constant: 25 deg/h");
  EXPECT_EQ(finding.where, "gyro");
  EXPECT_EQ(sentence(finding), finding.message);
}

TEST(Finding, ItsReasonIsTranslated) {
  const Finding finding(Finding::Severity::error, "segment_not_measurable",
                        {{"reason", Sentence("the signal does not move: there is no line in it")}}, "10 Hz");
  EXPECT_TRUE(message_in(Language::chinese, finding).ends_with("信号不变：其中没有谱线"))
      << message_in(Language::chinese, finding);
  EXPECT_TRUE(in_language(Language::chinese, errors_among({finding}).at(0)).ends_with("信号不变：其中没有谱线"));
}

TEST(Finding, OfAnotherProjectBringsItsSentence) {
  const Finding finding(Severity::info, Phrase{"my_code", "{count:jump} of {size:.1f} {how}"},
                        {{"size", -0.01, "K"}, {"how", Phrase{"my_word", "upwards"}}}, "oven", {2, 1.0, 3.0});
  EXPECT_EQ(finding.code, "my_code");
  EXPECT_EQ(finding.message, "2 jumps of 0.0 K upwards");  // without the sign of a zero
}

TEST(Finding, HasTheTextOfItsCount) {
  const std::vector<FindingValue> values{{"lost", 3}, {"longest", 0.31, "s"}};
  EXPECT_EQ(Finding(Severity::warning, "gap", values, "", {1, 2.5, 2.5}).message,
            "gap of 310 ms at 2.5 s: 3 samples lost; methods that need a constant rate cannot use data across a gap");
  EXPECT_EQ(Finding(Severity::warning, "gap", values, "", {2, 2.5, 7.0}).message,
            "2 gaps, 3 samples lost; the longest: 310 ms at 7 s; methods that need a constant rate cannot use data "
            "across a gap");
}

TEST(Finding, NumbersAreWrittenAsTheSentenceSays) {
  const Finding rate = with({{"rate", si(12.34567, "deg/h"), "deg/h"}, {"share", 0.01234, "%"}, {"ratio", 2.0 / 3.0}});
  EXPECT_EQ(filled("{rate}", rate), "12.35 deg/h");
  EXPECT_EQ(filled("{rate:.2g}", rate), "12 deg/h");
  EXPECT_EQ(filled("{rate:.1f -}", rate), "12.3");
  EXPECT_EQ(filled("{rate:.4g deg/s}", rate), "0.003429 deg/s");  // 12.34567/3600
  EXPECT_EQ(filled("{rate: deg/s}", rate), "0.003429 deg/s");
  EXPECT_EQ(filled("{rate:exact}", rate), "12.34567 deg/h");
  EXPECT_EQ(filled("{share:.2g}", rate), "1.2 %");
  EXPECT_EQ(filled("{ratio}", rate), "0.6667");
}

TEST(Finding, DifferenceOfTemperaturesHasNoZero) {
  const Finding finding = with({{"rise", 1.5, "degC"}, {"temperature", si(20.0, "degC"), "degC"}});
  EXPECT_EQ(filled("{rise:difference}", finding), "1.5 degC");
  EXPECT_EQ(filled("{temperature}", finding), "20 degC");
}

TEST(Finding, TimesAndSizesAreShownInTheUnitThatSuits) {
  const Finding finding =
      with({{"short", 0.31, "s"}, {"long", 12.5, "s"}, {"begin", 812.4, "s"}, {"size", 1500000000}});
  EXPECT_EQ(filled("{short:duration}, {long:duration}", finding), "310 ms, 12.5 s");
  EXPECT_EQ(filled("{begin:instant}", finding), "812.4 s");
  EXPECT_EQ(filled("{size:bytes}", finding), "1.5 GB");
}

TEST(Finding, CountsNamesAndPhrasesStandInTheSentence) {
  const Finding finding = with({{"lost", 1}, {"left", 3}, {"name", "gyro.x"}, {"of", Phrase{"temperature"}}}, {7});
  EXPECT_EQ(filled("{lost:sample}, {left:sample}, {left}", finding), "1 sample, 3 samples, 3");
  EXPECT_EQ(filled("'{name}': {of}", finding), "'gyro.x': a temperature");
  EXPECT_EQ(filled("{count} of {count:segment}", finding), "7 of 7 segments");
}

TEST(Finding, PlacesAreLabelsOrTimes) {
  EXPECT_EQ(filled("{first}, {worst}", with({}, {2, 1.25, {"run 2", 7.0}})), "1.25 s, run 2");
  EXPECT_EQ(filled("{first}, {worst}", with({}, {2, std::nan(""), {}})), "nan s, nan s");
}

TEST(Finding, AbsentValueOrUnknownCodeIsADefect) {
  EXPECT_TRUE(refuses(Error::Kind::internal, Asked{.values = {"test"}}, [&] {
    filled("{rate}", with({{"ratio", 1.0}}));
  }));
  EXPECT_TRUE(refuses(Error::Kind::internal, Asked{.values = {"constant_output"}},
                      [&] { Finding(Severity::info, "constant_output", {}); }));
  EXPECT_TRUE(refuses(Error::Kind::internal, Asked{.values = {"finding", "no_such_code"}},
                      [&] { Finding(Severity::info, "no_such_code", {}); }));
  EXPECT_TRUE(refuses(Error::Kind::internal, Asked{.values = {"no_such_phrase"}}, [&] {
    filled("{of}", with({{"of", Phrase{"no_such_phrase"}}}));
  }));
  try {
    text_of("finding", "no_such_code");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::internal);
  }
}

TEST(Finding, IsSaidInChineseByItsCodeAndValues) {
  const std::vector<FindingValue> values{{"lost", 3}, {"longest", 0.31, "s"}};
  const Finding once(Severity::warning, "gap", values, "gyro", {1, 2.5, 2.5});
  EXPECT_EQ(message_in(Language::chinese, once),
            "2.5 s 处数据中断 310 ms，丢失 3 个采样点；要求等间隔采样的方法不能跨中断处使用数据");
  EXPECT_EQ(placed_message_in(Language::chinese, once), "gyro：" + message_in(Language::chinese, once));
  EXPECT_EQ(message_in(Language::english, once), once.message);
  EXPECT_NE(message_in(Language::chinese, Finding(Severity::warning, "gap", values, "", {2, 2.5, 7.0}))
                .find("数据中断 2 处，共丢失 3 个采样点；最长 310 ms，位于 7 s"),
            std::string::npos);
}

TEST(Finding, ChinesePercentHasNoBlankAndPhrasesAreTranslated) {
  const Finding missing(Severity::info, "missing_samples", {{"samples", 200}, {"part", 0.01, "%"}, {"longest", 1}}, "",
                        {2, 1.0, 1.5});
  EXPECT_EQ(message_in(Language::chinese, missing), "200 个采样点中缺失 2 个（1%），最长连续缺失 1 个，始于 1.5 s");
  const Finding unit(Severity::info, "no_unit", {{"name", "t"}, {"expected", Phrase{"temperature"}}});
  EXPECT_EQ(message_in(Language::chinese, unit), "通道没有单位；“t”应为温度，或为原始输出");
}

TEST(Finding, AListHasTheMarksOfTheLanguage) {
  const Finding plain(Severity::info, "not_excited", {{"terms", "D_OO, D_SS"}});
  EXPECT_TRUE(plain.message.ends_with("D_OO, D_SS")) << plain.message;
  EXPECT_TRUE(message_in(Language::chinese, plain).ends_with("：D_OO、D_SS")) << message_in(Language::chinese, plain);
  const Finding quoted(Severity::info, "one_position_of_several_labels", {{"segments", "'a', 'b, c'"}});
  EXPECT_TRUE(message_in(Language::chinese, quoted).starts_with("方案中“a”、“b, c”为同一位置"))
      << message_in(Language::chinese, quoted);
}

/// A method of your own, and results of other versions: their English is better than nothing.
TEST(Finding, WithoutAChineseSentenceStaysEnglish) {
  const Finding own(Severity::info, Phrase{"my_code", "{count:jump} upwards"}, {}, "oven", {2});
  EXPECT_EQ(message_in(Language::chinese, own), "2 jumps upwards");
  Finding without_values;
  without_values.code = "gap";
  without_values.message = "gap of 1 s";
  EXPECT_EQ(message_in(Language::chinese, without_values), "gap of 1 s");
}

TEST(Finding, ErrorsAreTheProblemsOfARefusal) {
  const Findings findings{{Severity::info, "no_samples", {}, "a"},
                          {Severity::error, "no_samples", {}, "b"},
                          {Severity::error, "no_samples", {}}};
  EXPECT_EQ(texts_of(errors_among(findings)),
            (std::vector<std::string>{"b: the channel has no samples", "the channel has no samples"}));
}

TEST(Finding, AsTheReasonOfARefusalIsTranslated) {
  const Finding finding(Finding::Severity::error, "frames_uncertain", {{"declaration", "imu_x"}}, "x.raw");
  EXPECT_EQ(in_language(Language::chinese, errors_among({finding}).at(0)),
            "x.raw：" + message_in(Language::chinese, finding));
  EXPECT_EQ(errors_among({finding}).at(0).text(), "x.raw: " + finding.message);
}

TEST(Finding, ItsCountLosesItsNounInChinese) {
  const Finding finding(Finding::Severity::error, "frames_lost", {{"byte", 7}, {"lost", 3}}, "", {.count = 1});
  EXPECT_EQ(in_language(Language::chinese, said_of(finding)), message_in(Language::chinese, finding));
}

}  // namespace
}  // namespace tumble
