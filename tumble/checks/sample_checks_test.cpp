#include <gtest/gtest.h>

#include <cmath>

#include "tumble/checks/testing/made_recordings.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

using namespace testing;

constexpr std::size_t many = 20'000;

std::vector<double> times(double factor, std::vector<double> values) {
  for (double& value : values) value *= factor;
  return values;
}

std::vector<double> rounded_to(double step, std::vector<double> values) {
  for (double& value : values) value = step * std::round(value / step);
  return values;
}

/// The sensor gives `share` of the samples, and the record holds them.
std::vector<double> held(double share, const std::vector<double>& values) {
  auto out = values;
  for (std::size_t i = 0; i < values.size(); ++i)
    out[i] = values[static_cast<std::size_t>(static_cast<double>(i) * share)];
  return out;
}

std::vector<double> tone(double frequency, double noise, std::uint64_t seed) {
  auto values = times(noise, white(many, seed));
  for (std::size_t i = 0; i < many; ++i)
    values[i] += 10.0 * std::sin(two_pi * frequency * static_cast<double>(i) / 100.0);
  return values;
}

std::string codes(std::string_view check, const std::vector<double>& values, const char* unit = "deg/h",
                  const std::vector<Mark>& marks = {}, const char* name = "gyro") {
  Recording one = recording({channel(name, unit, values)});
  one.marks = marks;
  std::string all;
  for (const Finding& finding : findings_of(check, one)) all += finding.code;
  return all;
}

TEST(SampleChecks, StepsBeyondTheNoiseAreSaid) {
  for (const double step : {2.7, 5.0, 20.0}) {
    auto values = white(many, 1);
    for (double& value : values) value += 3.0 * step + 0.2 * step;
    EXPECT_EQ(codes("coarse_steps", rounded_to(step, values)), step < 10.0 ? "steps_exceed_noise" : "") << step;
  }
  EXPECT_EQ(codes("coarse_steps", rounded_to(1.0, tone(1.3, 0.05, 2))), "steps_exceed_noise");
  EXPECT_EQ(codes("coarse_steps", rounded_to(1.0, tone(31.7, 0.05, 2))), "steps_exceed_noise");
}

TEST(SampleChecks, ARampWithoutNoiseHasNoSteps) {
  const auto ramps = series(many, [](std::size_t i) {
    const double t = static_cast<double>(i % 2000) / 100.0;
    return t < 5.0 ? 0.0 : t < 10.0 ? 10.0 * (t - 5.0) : 50.0;
  });
  EXPECT_EQ(codes("coarse_steps", ramps), "");
  const auto one = series(40, [](std::size_t i) { return 0.001 * static_cast<double>(i); });
  EXPECT_EQ(codes("coarse_steps", one), "");
}

TEST(SampleChecks, StepsWithinTheNoiseAreNot) {
  for (const double step : {0.01, 0.5, 1.0, 2.0})
    EXPECT_EQ(codes("coarse_steps", rounded_to(step, white(many, 3))), "");
  EXPECT_EQ(codes("coarse_steps", tone(1.3, 0.0, 1)), "");
  EXPECT_EQ(codes("coarse_steps", tone(31.7, 1e-3, 1)), "");
  EXPECT_EQ(codes("coarse_steps", series(many, [](std::size_t i) { return 0.1 * static_cast<double>(i); })), "");
  EXPECT_EQ(codes("coarse_steps", std::vector<double>(many, 1.0)), "");
  // an encoder and a thermometer may well be coarse
  EXPECT_EQ(codes("coarse_steps", rounded_to(5.0, white(many, 1)), "deg", {}, "table_angle"), "");
  EXPECT_EQ(codes("coarse_steps", rounded_to(5.0, white(many, 1)), "degC", {}, "temperature"), "");
}

TEST(SampleChecks, CountsOfADividerAreSaid) {
  EXPECT_EQ(codes("coarse_steps", rounded_to(4.0, times(100.0, white(many, 4))), "pulse"), "counts_in_steps");
  EXPECT_EQ(codes("coarse_steps", rounded_to(1.0, times(100.0, white(many, 4))), "pulse"), "");
  // a few positions with counts that happen to be even
  EXPECT_EQ(codes("coarse_steps", series(many, [](std::size_t i) { return i < 9000    ? 20.0
                                                                          : i < 12000 ? 44.0
                                                                                      : 0.0; }),
                  "pulse"),
            "");
  // few steps, and the noise passes from one to the next: not a dead band; single pulses of a rebalance loop are neither
  const auto few = rounded_to(94.0, times(40.0, white(many, 4)));
  EXPECT_EQ(codes("coarse_steps", few, "pulse"), "counts_in_steps");
  EXPECT_EQ(codes("zeros", few, "pulse"), "");
  EXPECT_EQ(codes("coarse_steps", rounded_to(1.0, times(0.5, white(many, 4))), "pulse"), "");
}

TEST(SampleChecks, ASlowerSensorIsSaid) {
  for (const double share : {0.73, 0.5, 0.25, 0.125, 0.9}) {
    EXPECT_EQ(codes("repeated_samples", held(share, white(many, 5))), "samples_repeat") << share;
    EXPECT_EQ(codes("repeated_samples", held(share, rounded_to(0.02, white(many, 5)))), "samples_repeat") << share;
    EXPECT_EQ(codes("repeated_samples", held(share, tone(1.3, 1e-3, 6))), "samples_repeat") << share;
  }
  const Finding found =
      finding_of("repeated_samples", recording({channel("gyro", "deg/h", held(0.73, white(many, 5)))}));
  EXPECT_NEAR(std::get<double>(found.values[0].value), 0.27, 0.01);
  EXPECT_NEAR(std::get<double>(found.values[2].value), 73.0, 0.5);
}

TEST(SampleChecks, SamplesThatRepeatByThemselvesAreNot) {
  for (const double step : {0.1, 0.5, 1.0, 2.0, 4.0})
    EXPECT_EQ(codes("repeated_samples", rounded_to(step, white(many, 7))), "") << step;
  EXPECT_EQ(codes("repeated_samples", rounded_to(0.5, tone(0.01, 0.0, 7))), "");
  EXPECT_EQ(codes("repeated_samples",
                  rounded_to(1.0, series(many, [](std::size_t i) { return 0.3 * static_cast<double>(i); }))),
            "");
  // windows of a steady count: 10, 10, 11, 10, 10, 11
  EXPECT_EQ(codes("repeated_samples",
                  series(many,
                         [](std::size_t i) {
                           const auto at = static_cast<double>(i);
                           return std::floor(10.37 * (at + 1.0)) - std::floor(10.37 * at);
                         }),
                  "pulse"),
            "");
}

TEST(SampleChecks, ZerosInPlaceOfSamplesAreSaid) {
  for (const double mean : {0.0, 2.0, 7.0, 100.0}) {
    auto values = white(many, 8);
    for (double& value : values) value += mean;
    EXPECT_EQ(codes("zeros", values), "") << mean;
    for (std::size_t i = 70; i < many; i += 200) values[i] = 0.0;
    EXPECT_EQ(codes("zeros", values), "zeros_in_place_of_samples") << mean;
  }
  auto counts = rounded_to(1.0, times(4.0, white(many, 11)));
  for (std::size_t i = 0; i < many; ++i) counts[i] = i % 200 == 70 ? 0.0 : counts[i] + 1000.0;
  EXPECT_EQ(codes("zeros", counts, "pulse"), "zeros_in_place_of_samples");
}

TEST(SampleChecks, ADeadBandIsSaid) {
  for (const double band : {0.3, 1.0, 3.0})
    for (const double mean : {0.0, 1.0}) {
      auto values = white(many, 9);
      for (double& value : values) {
        value += mean;
        if (std::abs(value) <= band) value = 0.0;
      }
      EXPECT_EQ(codes("zeros", values), "no_value_near_zero") << band << " " << mean;
    }
  auto moving = tone(1.3, 1e-3, 10);
  for (double& value : moving) value = std::abs(value) <= 2.0 ? 0.0 : value;
  EXPECT_EQ(codes("zeros", moving), "no_value_near_zero");
  auto counts = rounded_to(1.0, times(4.0, white(many, 11)));
  EXPECT_EQ(codes("zeros", counts, "pulse"), "");
  for (double& count : counts) count = std::abs(count) <= 1.0 ? 0.0 : count;
  EXPECT_EQ(codes("zeros", counts, "pulse"), "no_value_near_zero");
  // a band that only the greatest values leave
  auto rare = rounded_to(1.0, times(30.0, white(many, 11)));
  for (double& count : rare) count = std::abs(count) <= 94.0 ? 0.0 : count;
  EXPECT_EQ(codes("zeros", rare, "pulse"), "no_value_near_zero");
}

// Rests of an output in steps that has a larger scale on its positive side: its values are no multiples of one step, and zero
// is one of them.
TEST(SampleChecks, AStepAtZeroOfAnOutputThatIsLargerOnOneSideIsNoPlaceholder) {
  const RandomStream random(14);
  auto values = series(many, [&](std::size_t i) {
    const double level = 0.37 * (static_cast<double>(i / 400) - 12.0) + 0.1 * random.normal(i);
    return (level > 0.0 ? 1.001 : 1.0) * std::round(level);
  });
  EXPECT_EQ(codes("zeros", values), "");
}

TEST(SampleChecks, ZerosOfItsOwnAreNot) {
  for (const double step : {0.1, 1.0, 2.0}) EXPECT_EQ(codes("zeros", rounded_to(step, white(many, 12))), "") << step;
  // a quiet counter that rests at nothing, and turns in between
  const std::vector<Mark> marks{{"rest", 0.0, 1}, {"turn", 50.0, 1}, {"rest", 100.0, 1}, {"turn", 150.0, 1}};
  auto counts = rounded_to(1.0, white(many, 13));
  for (std::size_t i = 0; i < many; ++i) counts[i] = (i / 5000) % 2 == 0 ? 0.0 : counts[i] + 1000.0;
  EXPECT_EQ(codes("zeros", counts, "pulse", marks), "");
  // few pulses a sample: zero lies between ones, or where a tone turns back
  const auto slow = series(many, [](std::size_t i) {
    const auto n = static_cast<double>(i);
    return std::floor(0.95 * (n + 1.0)) - std::floor(0.95 * n);
  });
  EXPECT_EQ(codes("zeros", slow, "pulse"), "");
  EXPECT_EQ(
      codes("zeros",
            rounded_to(1.0,
                       series(many, [](std::size_t i) { return 3.2 + 3.3 * std::sin(2.1 * static_cast<double>(i)); })),
            "pulse"),
      "");
  auto set = series(many, [](std::size_t i) { return (i / 5000) % 2 == 0 ? 0.0 : 10.0; });
  EXPECT_EQ(codes("zeros", set, "deg/s", marks), "");
}

TEST(SampleChecks, ValuesThatDecidedAboutTheirLossAreSaid) {
  auto values = white(many, 14);
  for (double& value : values) value = value > 1.28 ? NAN : value;
  EXPECT_EQ(codes("lost_by_value", values), "largest_values_missing");
  for (double& value : values) value = -value;
  EXPECT_EQ(codes("lost_by_value", values), "smallest_values_missing");
  auto moving = tone(1.3, 1e-3, 15);
  for (double& value : moving) value = value > 9.0 ? NAN : value;
  EXPECT_EQ(codes("lost_by_value", moving), "largest_values_missing");
  auto coarse = rounded_to(0.5, white(many, 16));
  for (double& value : coarse) value = value > 1.3 ? NAN : value;
  EXPECT_EQ(codes("lost_by_value", coarse), "largest_values_missing");
}

TEST(SampleChecks, LossesByChanceAreNot) {
  const RandomStream random(17);
  for (auto values : {white(many, 18), tone(1.3, 1e-3, 19), tone(1.3, 0.0, 19), rounded_to(0.5, white(many, 20))}) {
    for (std::size_t i = 0; i < many; ++i)
      if (random.uniform(i) < 0.1) values[i] = NAN;
    EXPECT_EQ(codes("lost_by_value", values), "");
  }
}

TEST(SampleChecks, KelvinUnderDegreesCelsiusIsSaid) {
  auto values = white(100, 21);
  for (double& value : values) value += 243.0;
  EXPECT_EQ(codes("units", values, "degC", {}, "temperature"), "probably_kelvin");
  for (double& value : values) value -= 150.0;
  EXPECT_EQ(codes("units", values, "degC", {}, "temperature"), "");
}

TEST(SampleChecks, CountsInThousandsAreSaid) {
  auto counts = rounded_to(1.0, times(3.0, white(many, 22)));
  for (double& count : counts) count += 12345.0;
  EXPECT_EQ(codes("units", counts, "pulse"), "");
  EXPECT_EQ(codes("units", times(1e-3, counts), "pulse"), "counts_not_whole");
  // means of counts, as they were printed
  auto means = times(3.0, white(many, 23));
  EXPECT_EQ(codes("units", rounded_to(1e-3, means), "pulse"), "");
}

/// A rig that reverses its acceleration: the rate has a peak, which nothing damaged.
TEST(SampleChecks, ACornerOfAMotionIsNoOutlier) {
  auto values = times(0.1, white(many, 12));
  for (std::size_t i = 0; i < many; ++i) values[i] += 1.6 * std::abs(static_cast<double>(i) - 15'000.0);
  EXPECT_EQ(codes("outliers", values, "deg/s"), "");
  values[15'000] += 10.0;
  EXPECT_EQ(codes("outliers", values, "deg/s"), "outlier");
}

// Counts repeat by chance; what is held shows where the unit moves fast, or by its pattern.
// Positions of a counter of few pulses: a pattern in one of them only.
TEST(SampleChecks, CountsOfManyRatesRepeatByChance) {
  std::size_t accused = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const auto noise = white(many / 4, seed);
    double all = 0.0;
    auto values = series(noise.size(), [&](std::size_t i) {
      const auto position = static_cast<double>(i / 600);
      const double before = std::round(all);
      all += 400.0 * std::sin(2.1 * position + 0.37 * static_cast<double>(seed)) + 0.55 * noise[i];
      return std::round(all) - before;
    });
    accused += codes("repeated_samples", values, "pulse").empty() ? 0 : 1;
  }
  EXPECT_EQ(accused, 0u);
}

TEST(SampleChecks, CountsThatAreHeldAreSaid) {
  auto moves = rounded_to(1.0, white(1000, 12));
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const auto t = static_cast<double>(i % 100);
    moves[i] += t < 70.0 ? 15.0 : 1000.0 * std::min(t - 69.0, 101.0 - t);
  }
  EXPECT_EQ(codes("repeated_samples", moves, "pulse"), "");
  EXPECT_EQ(codes("repeated_samples", held(0.73, moves), "pulse"), "samples_repeat");
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
    const auto few = rounded_to(1.0, times(0.65, white(400, seed)));
    EXPECT_EQ(codes("repeated_samples", few, "pulse"), "") << seed;
    EXPECT_EQ(codes("repeated_samples", held(0.73, few), "pulse"), "samples_repeat") << seed;
  }
  // 1.33 counts a window: 1, 1, 2, and so on, with and without noise
  for (const double noise : {0.0, 0.05, 0.2, 0.5})
    for (const double rate : {1.33, 1.7, 7.9, 2.27}) {
      const auto scatter = white(many, 13);
      const auto at = [&](std::size_t i) { return std::floor(rate * static_cast<double>(i) + noise * scatter[i]); };
      EXPECT_EQ(codes("repeated_samples", series(many - 1, [&](std::size_t i) { return at(i + 1) - at(i); }), "pulse"),
                "")
          << rate << " " << noise;
    }
}

// One zero in the middle of a move or far from the noise is no count.
TEST(SampleChecks, ASingleZeroInACourseOfCountsIsSaid) {
  auto values = rounded_to(1.0, white(many, 14));
  for (std::size_t i = 0; i < many; ++i)
    values[i] += 16.0 + (i % 500 < 20 ? 1000.0 * static_cast<double>(i % 500) : 0.0);
  EXPECT_EQ(codes("zeros", values, "pulse"), "");
  for (const std::size_t at : {700u, 1010u}) {
    auto one = values;
    one[at] = 0.0;
    EXPECT_EQ(codes("zeros", one, "pulse"), "zeros_in_place_of_samples") << at;
  }
}

}  // namespace
}  // namespace tumble
