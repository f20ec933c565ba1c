// How far each kind of motion goes, and what the limits of a station say of it.
#include "tumble/station/station_file/motion_limits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/shaped_noise.hpp"
#include "tumble/station/station_file.hpp"
#include "tumble/station/station_file/motion_extremes.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using station_file::beyond_limits;
using station_file::extremes_of;
using Kind = Motion::Kind;

/// 0.01 u^2/Hz from 20 Hz to 50 Hz.
Motion small_random() { return {.kind = Kind::random, .psd_frequency = {20.0, 50.0}, .psd = {0.01, 0.01}}; }

/// One motion of each kind, by their order; the last one is the last kind of the list.
std::vector<Motion> motions_of_each_kind() {
  return {{.kind = Kind::hold, .value = 2.0},
          {.kind = Kind::rate, .value = -2.0},
          {.kind = Kind::slew, .value = 2.0, .to = 2.0},
          {.kind = Kind::sine, .amplitude = 2.0, .frequency = 1.0},
          {.kind = Kind::sweep, .amplitude = 2.0, .frequency = 1.0, .to_frequency = 2.0},
          small_random(),
          {.kind = Kind::ramp, .value = 2.0, .to = 2.0},
          {.kind = Kind::dwell, .value = 2.0}};
}

StationAxis limited_axis(StationAxis::Kind kind) {
  StationAxis axis;
  axis.name = "it";
  axis.kind = kind;
  axis.lowest = -1.0;
  axis.highest = 1.0;
  axis.max_rate = axis.max_acceleration = 1.0;
  return axis;
}

const Asked beyond{.values = {"s", "it"}, .pattern = "is beyond the station's"};

TEST(MotionLimits, NoKindOfMotionLeavesTheTable) {
  const auto motions = motions_of_each_kind();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    ASSERT_EQ(static_cast<std::size_t>(motions[i].kind), i) << "a kind is missing in the test";
    for (const auto kind :
         {StationAxis::Kind::angle, StationAxis::Kind::temperature, StationAxis::Kind::acceleration}) {
      StationAxis axis = limited_axis(kind);
      const bool is_rate_of_a_shaker = kind == StationAxis::Kind::acceleration && motions[i].kind == Kind::random;
      if (is_rate_of_a_shaker) axis.max_acceleration = 0.5;
      const Segment segment{"s", 10.0, 1, {}};
      EXPECT_TRUE(has_problem(beyond_limits(segment, axis, motions[i], 0.0), beyond))
          << i << " of " << static_cast<int>(kind);
      axis.lowest = -1e9, axis.highest = 1e9, axis.max_rate = axis.max_acceleration = 1e9;
      EXPECT_TRUE(beyond_limits(segment, axis, motions[i], 0.0).empty()) << i << " of " << static_cast<int>(kind);
    }
  }
}

TEST(MotionLimits, SaysTheExtremesOfEachKind) {
  const auto motions = motions_of_each_kind();
  const auto of = [&](Kind kind) { return extremes_of(motions[static_cast<std::size_t>(kind)], 10.0, {}); };
  EXPECT_EQ(of(Kind::hold).place, 2.0);
  EXPECT_EQ(of(Kind::rate).lowest, -20.0);
  EXPECT_EQ(of(Kind::rate).highest, 0.0);
  EXPECT_EQ(of(Kind::rate).rate, -2.0);
  EXPECT_EQ(of(Kind::slew).rate, 2.0);
  EXPECT_EQ(of(Kind::ramp).place, 2.0);
  EXPECT_DOUBLE_EQ(of(Kind::sine).rate, 2.0 * two_pi);
  EXPECT_DOUBLE_EQ(of(Kind::sine).acceleration, 2.0 * two_pi * two_pi);
  EXPECT_DOUBLE_EQ(of(Kind::sweep).rate, 4.0 * two_pi);
  EXPECT_GE(of(Kind::sweep).acceleration, 2.0 * 4.0 * two_pi * two_pi);
  const auto clipped = extremes_of(small_random(), 10.0, 3.0);
  EXPECT_NEAR(clipped.highest, 3.0 * std::sqrt(0.3), 1e-12);
  EXPECT_NEAR(clipped.rate, 3.0 * two_pi * std::sqrt(0.01 * (125000.0 - 8000.0) / 3.0), 1e-9) << "of f^2 S";
}

/// One of a hundred segments exceeds the peak: of 400 as many as a binomial law has, at most four of its standard
/// deviations more.
TEST(MotionLimits, TheProcessKeepsToItsPeak) {
  const SpectralDensity psd{{20.0, 50.0}, {0.01, 0.01}};
  const double seconds = 2.0, step = 0.0005, peak = extremes_of(small_random(), seconds, {}).highest;
  int beyond = 0;
  std::vector<double> values(static_cast<std::size_t>(seconds / step));
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    ShapedNoise(psd, RandomStream(seed)).values(0.0, step, values);
    if (std::ranges::any_of(values, [&](double value) { return std::abs(value) > peak; })) ++beyond;
  }
  EXPECT_GT(beyond, 0) << "a peak that nothing ever reaches is not the one that is stated";
  EXPECT_LE(beyond, 4 + 8);
}

TEST(MotionLimits, PeaksOfARandomVibrationAreComparedWithTheAcceleration) {
  StationAxis axis = limited_axis(StationAxis::Kind::acceleration);
  axis.lowest.reset(), axis.highest.reset(), axis.max_rate.reset();
  const Segment segment{"shake", 60.0, 1, {}};
  axis.max_acceleration = 1.7;  // 3 times 0.548 m/s^2 is 1.64
  const auto problems = beyond_limits(segment, axis, small_random(), {});
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_TRUE(is_problem(problems[0], {.values = {"shake"}, .pattern = "standard deviations"}));
  EXPECT_TRUE(is_problem(problems[0], {.values = {"shake"}, .pattern = "`clips_at`"}));
  axis.clips_at = 3.0;
  EXPECT_TRUE(beyond_limits(segment, axis, small_random(), {}).empty());
  axis.clips_at = 4.0;
  EXPECT_EQ(beyond_limits(segment, axis, small_random(), {}).size(), 1u);
}

TEST(MotionLimits, WhatIsNoNumberIsBeyondThem) {
  const StationAxis axis = limited_axis(StationAxis::Kind::angle);
  for (const Kind kind : {Kind::rate, Kind::hold})
    EXPECT_TRUE(has_problem(beyond_limits({"s", 1.0, 1, {}}, axis, {.kind = kind, .value = NAN}, 0.0), beyond));
}

/// Problems of a station whose safe list sets a chamber to this temperature.
Refused refused_safe(const std::string& temperature, const std::string& limits) {
  return refusal_of([&] {
    read_station(
        "[station]\nname = \"bench\"\n[[device]]\nname = \"oven\"\ncontroller = \"espec_p300\"\nlink = "
        "\"tcp:host:1\"\n[[device.axis]]\nrig = \"chamber\"\nmoves = \"temperature\"\nsettle = {temperature = "
        "\"0.5 K\", hold = \"1 min\"}\n" +
            limits + "[[safe]]\ndevice = \"oven\"\nverb = \"set_temperature\"\ntemperature = \"" + temperature + "\"\n",
        "bench.toml");
  });
}

TEST(MotionLimits, ASafeTemperatureKeepsToThem) {
  const std::string limits = "lowest = \"-40 degC\"\nhighest = \"85 degC\"\n";
  const auto input = Error::Kind::bad_input;
  EXPECT_TRUE(refused_safe("23 degC", limits).empty());
  EXPECT_TRUE(
      refuses(input, Asked{.values = {"chamber", "90", "degC", "85", "degC"}}, refused_safe("90 degC", limits)));
  EXPECT_TRUE(
      refuses(input, Asked{.values = {"chamber", "-41", "degC", "-40", "degC"}}, refused_safe("-41 degC", limits)));
  EXPECT_TRUE(refuses(input, Asked{.values = {"chamber", "93", "degC", "85", "degC"}},
                      refused_safe("73 degC", limits + "offset = \"20 K\"\n")))
      << "the limits are those of the axis, and the command is that of the controller";
  EXPECT_TRUE(refused_safe("90 degC", "").empty());
  EXPECT_TRUE(refuses(input, Asked{.values = {"1e+300"}, .pattern = "is not a temperature of a chamber"},
                      refused_safe("1e300 degC", "")));
  EXPECT_TRUE(refuses(input, Asked{.values = {"-300"}, .pattern = "is not a temperature of a chamber"},
                      refused_safe("-300 degC", "")));
}

}  // namespace
}  // namespace tumble
