#include "tumble/report/in_language.hpp"

#include <gtest/gtest.h>

#include "tumble/report/names.hpp"

namespace tumble {
namespace {

constexpr auto zh = Language::chinese;

Estimate example() {
  Estimate estimate;
  estimate.method = "accelerometer_tumble", estimate.title = "accelerometer_tumble of day 1.csv";
  estimate.provenance.inputs.push_back({"june/day 1.csv", ""});
  estimate.parameters = {{"bias", "K_0", Unit::parse("mg"), 0.0, "bias"}};
  estimate.budget = {{"positioning of head", "", {}}};
  estimate.tables = {{"positions",
                      "residuals of positions that were taken more than once",
                      {{"label", {}}, {"a_residual", {}}, {"used", {}}},
                      {{std::string("rest"), 1.0, std::string("yes")}}}};
  return estimate;
}

TEST(InLanguage, EnglishIsUnchanged) {
  const auto estimate = in_language(Language::english, example());
  EXPECT_EQ(estimate.budget[0].source, "positioning of head");
  EXPECT_EQ(readable_name(Language::english, "angle_random_walk"), "angle random walk");
}

TEST(InLanguage, WordsAreChineseAndNamesStay) {
  const auto estimate = in_language(zh, example());
  EXPECT_EQ(estimate.title, "加速度计重力场翻滚试验：day 1.csv");
  EXPECT_EQ(estimate.parameters[0].name, "bias");
  EXPECT_EQ(estimate.budget[0].source, "分度头定位误差");
  const Table& table = estimate.tables[0];
  EXPECT_EQ(table.name, "positions");
  EXPECT_EQ(table.caption, "重复测量位置的残差");
  EXPECT_EQ(table.columns[1].name, "a 残差");
  EXPECT_EQ(std::get<std::string>(table.rows[0][0]), "rest") << "the label of a segment is the user's";
  EXPECT_EQ(std::get<std::string>(table.rows[0][2]), "是");
}

TEST(InLanguage, ANameMayMeanSomethingElseInOneMethod) {
  EXPECT_EQ(in_language(zh, example()).parameters[0].description, "偏值");
  EXPECT_EQ(readable_name(zh, "bias", "accelerometer_tumble"), "偏值");
  EXPECT_EQ(readable_name(zh, "bias", "static_bias"), "零偏");
}

TEST(InLanguage, AFigureIsDrawnInItsLanguage) {
  Figure figure{"gain over frequency",
                {"frequency", Unit::parse("Hz"), true},
                {"gain", {}},
                {{.name = "S1", .x = {1, 2}, .y = {3, 4}}},
                {}};
  figure.notes = {"colourless ideas"};
  const auto chinese = in_language(zh, figure);
  EXPECT_EQ(chinese.name, "增益随频率的变化");
  EXPECT_EQ(title_of(chinese.x), "频率 [Hz]");
  EXPECT_EQ(chinese.series[0].name, "S1");
  EXPECT_EQ(chinese.notes, figure.notes) << "what the table lacks stays English";
  const auto drawing = to_svg(chinese);
  EXPECT_NE(drawing.find("lang=\"zh-CN\""), std::string::npos);
  EXPECT_NE(drawing.find(">频率 [Hz]</text>"), std::string::npos);
  EXPECT_NE(drawing.find("曲线图"), std::string::npos) << "the plot in words";
  EXPECT_EQ(to_csv(figure).substr(0, 14), "frequency[Hz],") << "files of numbers never change";
}

}  // namespace
}  // namespace tumble
