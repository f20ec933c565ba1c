#include <gtest/gtest.h>

#include "tumble/report/legacy/legacy.hpp"

namespace tumble::legacy {
namespace {

using Severity = Finding::Severity;
using Indices = std::vector<std::size_t>;

std::vector<Parameter> parameters() {
  std::vector<Parameter> all;
  for (const char* name : {"gyro.angle_random_walk", "gyro_x_bias", "bias", "S2.gain_10Hz"})
    all.push_back({name, "", Unit(), 1.0, ""});
  return all;
}

TEST(LegacyFinding, ConcernsTheParametersOfItsPlace) {
  const auto at = [](const char* where) { return about_of({Severity::error, "no_samples", {}, where}, parameters()); };
  EXPECT_EQ(at("bias"), Indices{2});
  EXPECT_EQ(at("gyro_x"), Indices{1});
  EXPECT_EQ(at("gyro"), (Indices{0, 1}));
  for (const char* where : {"", "today.csv", "today.csv, gyro", "accelerometer"})
    EXPECT_EQ(at(where), Indices{}) << where;
}

TEST(LegacyFinding, ConcernsTheParametersThatItLists) {
  Finding finding;
  finding.severity = Severity::error, finding.code = "out_of_range";
  finding.values = {{"parameters", "S2.gain_10Hz bias"}};
  EXPECT_EQ(about_of(finding, parameters()), (Indices{3, 2}));
  finding.values = {{"parameters", "S2.gain_1"}};
  EXPECT_EQ(about_of(finding, parameters()), Indices{});
  finding.code = "wrong_sign", finding.where = "bias";
  EXPECT_EQ(about_of(finding, parameters()), Indices{}) << "all of them";
}

TEST(LegacyFinding, LimitsWhatItsChannelsHide) {
  Finding finding;
  finding.code = "noise_term_not_significant", finding.where = "gyro.x, gyro.y";
  finding.values = {{"term", "rate_random_walk"}, {"limit", 1.0}};
  const auto hidden = hidden_by(finding);
  ASSERT_EQ(hidden.size(), 2u);
  EXPECT_EQ(hidden[1].name, "gyro.y.rate_random_walk");
  EXPECT_EQ(hidden[1].channel, "gyro.y");
  finding.code = "not_significant", finding.values = {{"parameter", "hysteresis"}, {"limit", 1.0}};
  ASSERT_EQ(hidden_by(finding).size(), 1u);
  EXPECT_EQ(hidden_by(finding)[0].name, "hysteresis");
  finding.code = "gap";
  EXPECT_TRUE(hidden_by(finding).empty());
}

TEST(LegacyFinding, HoldsTheMemoryOfARecordingInBlocks) {
  Finding finding;
  finding.code = "processed_in_blocks", finding.values = {{"size", 9e9}, {"memory", 8'000'000}};
  EXPECT_EQ(memory_of({finding}), 8'000'000u);
  finding.code = "gap";
  EXPECT_FALSE(memory_of({finding}));
}

}  // namespace
}  // namespace tumble::legacy
