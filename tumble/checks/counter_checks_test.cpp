// Checks of pulse counters and their windows.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "tumble/checks/testing/made_recordings.hpp"

namespace tumble {
namespace {

using namespace testing;

TEST(Checks, CounterThatRunsOver) {
  const auto noise = white(4000, 31);
  // 65 530 pulses a window and a scatter of 3, in 16 bits.
  auto wrapped = series(4000, [&](std::size_t i) { return std::round(65'530.0 + 3.0 * noise[i]); });
  std::size_t over = 0;
  for (double& value : wrapped)
    if (value > 65'535.0) value -= 65'536.0, ++over;
  ASSERT_GT(over, 50u);
  const Findings found = findings_of("counter_overflow", recording({counts(wrapped)}));
  ASSERT_EQ(found.size(), 1u) << said(found);
  EXPECT_EQ(found[0].severity, Finding::Severity::error);
  EXPECT_TRUE(is_finding(found[0], "counter_overflow",
                         {{"bits", 16}, {"register", Phrase{"unsigned_register"}}, {"size", 65536}}, "accelerometer"));
  // With sign, and a total that runs on.
  for (const int bits : {16, 24, 32}) {
    const double size = std::ldexp(1.0, bits), step = size / 500.0;
    const auto total = series(4000, [&](std::size_t i) {
      const double sum = std::floor(step * static_cast<double>(i));
      return sum - size * std::floor(sum / size + 0.5);
    });
    const Finding signed_total = finding_of("counter_overflow", recording({counts(total)}));
    EXPECT_TRUE(is_finding(signed_total, "counter_overflow",
                           {{"bits", bits}, {"register", Phrase{"signed_register"}}, {"size", std::llround(size)}}));
    EXPECT_EQ(signed_total.occurrences.count, 8u) << bits;
  }
}

// A converter whose values go on over its end comes back at the other one, in counts and in units of the sensor.
TEST(Checks, ValuesThatGoOnOverTheEndOfTheirRegister) {
  const auto noise = white(20'000, 33);
  for (const double sd : {300.0, 3000.0, 12'000.0}) {
    const auto turned = series(noise.size(), [&](std::size_t i) {
      const double count = std::round(32'768.0 - sd + sd * noise[i]);
      return count - 65'536.0 * std::floor(count / 65'536.0 + 0.5);
    });
    auto rates = turned, cut = turned, held = turned;
    for (double& value : rates) value *= 0.0175;
    for (std::size_t i = 0; i < cut.size(); ++i) {
      held[i] = 0.0175 * std::clamp(std::round(32'768.0 - sd + sd * noise[i]), -32'768.0, 32'767.0);
      cut[i] = 0.0175 * std::clamp(2.0 * sd * noise[i], -32'768.0, 32'767.0);
    }
    const auto said_of = [](const std::vector<double>& values) {
      return findings_of("counter_overflow", recording({channel("gyro", "deg/s", values)}));
    };
    const Findings found = said_of(rates);
    ASSERT_EQ(found.size(), 1u) << sd;
    EXPECT_TRUE(is_finding(found[0], "counter_overflow",
                           {{"bits", 16}, {"register", Phrase{"signed_register"}}, {"size", 65536}}, "gyro"));
    EXPECT_EQ(findings_of("counter_overflow", recording({counts(turned)})).size(), 1u) << sd;
    EXPECT_EQ(said(said_of(held)), "") << sd;
    EXPECT_EQ(said(said_of(cut)), "") << sd;
  }
}

TEST(Checks, CounterThatStopsAtItsEnd) {
  const auto noise = white(4000, 32);
  const auto stopped =
      series(4000, [&](std::size_t i) { return std::min(4095.0, std::round(4090.0 + 5.0 * noise[i])); });
  EXPECT_TRUE(is_finding(finding_of("counter_overflow", recording({counts(stopped)})), "counter_stopped",
                         {{"bits", 12}, {"register", Phrase{"unsigned_register"}}, {"counts", 4095}}, "accelerometer"));
}

// A position of a unit with a noise of two pulses cannot show the same count forty times: the range of its counter ends there.
TEST(Checks, CountsThatAreCutOffInAPositionAreSaturated) {
  auto counts = white(400, 8);
  for (std::size_t i = 0; i < 400; ++i)
    counts[i] = std::round((i < 200 ? 3.0 : i < 260 ? 500.0 : -20.0) + 1.2 * counts[i]);
  Recording three = recording({channel("accelerometer", "pulse", counts, 1.0)});
  three.marks = {{"a", 0.0, 1}, {"b", 200.0, 1}, {"c", 260.0, 1}};
  EXPECT_EQ(said(findings_of("saturation", three)), "");
  for (double& count : three.channels[0].values) count = std::min(count, 450.0);
  const Finding cut = finding_of("saturation", three);
  EXPECT_EQ(cut.code, "saturated_highest");
  EXPECT_EQ(cut.occurrences.count, 60u);
}

TEST(Checks, CounterReadTooLate) {
  const auto noise = white(4000, 33);
  auto values = series(4000, [&](std::size_t i) { return std::round(500.0 + 4.0 * noise[i]); });
  values[1000] = 1003.0;
  values[2000] = 2498.0;
  const Finding late = finding_of("missed_windows", recording({counts(values)}));
  EXPECT_TRUE(is_finding(late, "missed_windows", {{"missed", 5}, {"times", 2}}, "accelerometer"));
  EXPECT_EQ(late.occurrences.count, 2u);
  EXPECT_DOUBLE_EQ(late.occurrences.first.time, 10.0);
  EXPECT_TRUE(findings_of("missed_windows", recording({channel("gyro", "deg/h", values)})).empty());
}

TEST(Checks, UnequalWindows) {
  const auto noise = white(4000, 34), other = white(4000, 35);
  std::vector<double> stamps(4000), follow(4000), late(4000);
  double now = 0.0;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    stamps[i] = now;
    const double length = 0.005 * (1.0 + 0.02 * noise[i]);
    now += length;
    follow[i] = std::round(1e5 * length + other[i]);
    late[i] = std::round(500.0 + other[i]);
  }
  const auto made = [&](std::vector<double> values) {
    Channel c = counts(std::move(values));
    c.timeline.rate = 0.0;
    c.timeline.stamps = std::make_shared<const std::vector<double>>(stamps);
    return recording({c});
  };
  const Finding unequal = finding_of("unequal_windows", made(follow));
  EXPECT_EQ(unequal.code, "unequal_windows");
  EXPECT_NEAR(std::get<double>(unequal.values.at(0).value), 0.02, 0.0011);  // 4 sd: 4 * 0.02 sqrt(1.5/8000)
  EXPECT_TRUE(findings_of("unequal_windows", made(late)).empty());
}

// A table that turns for half a minute at 127 400 pulses a window: its register of 17 bits runs over on the way.
TEST(Checks, AMotionThatLeavesItsRegister) {
  const auto course = [](std::size_t i) {
    const auto t = static_cast<double>(i % 100);
    const double fast = 127'400.0;
    return std::round(t < 40.0   ? 15.0
                      : t < 50.0 ? fast * (t - 39.7) / 10.3
                      : t < 80.0 ? fast
                      : t < 90.0 ? fast * (90.0 - t) / 10.3
                                 : 15.0);
  };
  const auto sound = series(400, course);
  EXPECT_TRUE(findings_of("counter_overflow", recording({counts(sound)})).empty());
  const double size = 131'072.0;
  auto wrapped = sound;
  for (double& value : wrapped) value -= size * std::floor(value / size + 0.5);
  const Finding over = finding_of("counter_overflow", recording({counts(wrapped)}));
  EXPECT_TRUE(is_finding(over, "counter_overflow", {{"bits", 17}, {"register", Phrase{"signed_register"}}}));
  EXPECT_EQ(over.occurrences.count, 8u);  // there and back, four times
  // a table that is driven to and fro between the ends of such a range does not
  const auto driven = series(400, [&](std::size_t i) { return course(i) - course(i + 50); });
  EXPECT_TRUE(findings_of("counter_overflow", recording({counts(driven)})).empty());
}

}  // namespace
}  // namespace tumble
