#include "tumble/tasks/compensation_report.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/report/figure.hpp"

namespace tumble {
namespace {

Channel channel(const char* name, const char* unit, std::vector<double> values) {
  Channel made;
  made.name = name, made.unit = Unit::parse(unit);
  made.timeline = {.start = 0.0, .rate = 10.0, .stamps = nullptr};
  made.values = std::move(values);
  return made;
}

/// 5000 samples of which the mean is 3 before and 1 after, with sd 0.5; one block lacks samples.
struct Example {
  Recording before;
  Compensation done;
  Example() {
    std::vector<double> raw, left, sd(5000, 0.5);
    for (int i = 0; i < 5000; ++i) raw.push_back(3.0 + (i % 3 - 1)), left.push_back(1.0 + (i % 3 - 1));
    for (int i = 300; i < 303; ++i) raw[static_cast<std::size_t>(i)] = left[static_cast<std::size_t>(i)] = NAN;
    before.channels = {channel("gyro", "rad/s", raw)};
    before.origin.file = "";
    done.recording.channels = {channel("gyro", "rad/s", left), channel("gyro.compensation_sd", "rad/s", sd)};
  }
};

TEST(CompensationReport, ShowsBeforeAfterAndWhatWasSubtracted) {
  const Example example;
  Estimate result;
  result.method = "fog_thermal_bias", result.instrument_serial = "F-1";
  const Estimate report = compensation_report(result, example.before, example.done);
  EXPECT_EQ(report.instrument_serial, "F-1");
  ASSERT_EQ(report.curves.size(), 3u);
  const auto& [before, after, difference] = std::tie(report.curves[0], report.curves[1], report.curves[2]);
  ASSERT_EQ(before.y.values.size(), 1667u);  // blocks of three samples
  EXPECT_NEAR(before.y.values[0], 3.0, 1e-12);
  EXPECT_NEAR(after.y.values[0], 1.0, 1e-12);
  EXPECT_NEAR(difference.y.values[0], 2.0, 1e-12);
  EXPECT_NEAR(difference.upper[0], 3.0, 1e-12);
  EXPECT_NEAR(before.x.values[0], 0.1, 1e-12);
  EXPECT_TRUE(std::isnan(before.y.values[100])) << "a block without samples is a gap";
  const auto figures = figures_of(report);
  ASSERT_EQ(figures.size(), 2u);
  EXPECT_EQ(figures[0].name, "gyro before and after compensation");
  EXPECT_EQ(figures[0].series.size(), 2u);
}

TEST(CompensationReport, AChannelOfAnotherKindHasNoDifference) {
  Example example;
  example.before.channels[0].unit = Unit::parse("mA");
  const Estimate report = compensation_report({}, example.before, example.done);
  EXPECT_EQ(report.curves.size(), 2u);
  EXPECT_EQ(figures_of(report).size(), 2u) << "other axes";
}

}  // namespace
}  // namespace tumble
