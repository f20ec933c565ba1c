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
  EXPECT_NE(found[0].message.find("passed the end of its unsigned register of 16 bits"), std::string::npos);
  EXPECT_NE(found[0].message.find("add or subtract 65536"), std::string::npos) << found[0].message;
  // With sign, and a total that runs on.
  for (const int bits : {16, 24, 32}) {
    const double size = std::ldexp(1.0, bits), step = size / 500.0;
    const auto total = series(4000, [&](std::size_t i) {
      const double sum = std::floor(step * static_cast<double>(i));
      return sum - size * std::floor(sum / size + 0.5);
    });
    EXPECT_NE(only("counter_overflow", recording({counts(total)}))
                  .find("signed register of " + std::to_string(bits) + " bits 8 times"),
              std::string::npos)
        << bits;
  }
}

TEST(Checks, CounterThatStopsAtItsEnd) {
  const auto noise = white(4000, 32);
  const auto stopped =
      series(4000, [&](std::size_t i) { return std::min(4095.0, std::round(4090.0 + 5.0 * noise[i])); });
  EXPECT_NE(only("counter_overflow", recording({counts(stopped)}))
                .find("stays at 4095, the end of its unsigned register of 12 bits, in "),
            std::string::npos);
}

TEST(Checks, CounterReadTooLate) {
  const auto noise = white(4000, 33);
  auto values = series(4000, [&](std::size_t i) { return std::round(500.0 + 4.0 * noise[i]); });
  values[1000] = 1003.0;
  values[2000] = 2498.0;
  EXPECT_EQ(
      only("missed_windows", recording({counts(values)})),
      "accelerometer: 2 windows hold the pulses of several (the first, at 10 s, 2 times those of its neighbours), 5 "
      "windows missed: the card was read too late, after it had counted further; leave such windows blank, or "
      "distribute "
      "their pulses over the missed windows");
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

}  // namespace
}  // namespace tumble
