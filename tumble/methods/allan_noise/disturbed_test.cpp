#include "tumble/methods/allan_noise/disturbed.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tumble/math/noise_model.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/noise_record.hpp"

namespace tumble::allan_noise {
namespace {

constexpr double rate = 100.0;
constexpr std::size_t hour = 360000;

EvenSignal simulated(const NoiseModel& model, std::size_t samples, std::uint64_t seed) {
  EvenSignal signal;
  signal.made.assign(samples, 0.01);
  add_noise(model, rate, RandomStream(seed), signal.made);
  signal.values = signal.made;
  signal.rate = rate;
  return signal;
}

std::vector<RecordPart> parts_of(const EvenSignal& signal) {
  return disturbed_parts(signal, block_scatter(signal.values));
}

/// Sine of one half to three periods from `begin`, as of a hand that touches the table.
void touch(double begin, double length, double amplitude, double periods, std::vector<double>& values) {
  const auto first = static_cast<std::size_t>(begin * rate), samples = static_cast<std::size_t>(length * rate);
  for (std::size_t i = 0; i < samples; ++i)
    values[first + i] +=
        amplitude * std::sin(2.0 * std::numbers::pi * periods * static_cast<double>(i) / static_cast<double>(samples));
}

Estimate identified(std::vector<double> values, const char* disturbed) {
  Evidence evidence = noise_evidence(std::move(values), rate);
  evidence.plan.settings.set_word("disturbed", disturbed);
  return identify_noise(evidence);
}

TEST(DisturbedParts, NoneInNoiseOfAnyColour) {
  // White: never (a block of 900 samples is known to 2.4 %). A walk's scatter within a block reaches 4 times the
  // median in 1 of 12 000 blocks, that about the block's line in less than 1 of 10^7.
  const NoiseModel models[] = {{.angle_random_walk = 1e-4},
                               {.angle_random_walk = 1e-4, .bias_instability = 1e-3, .rate_random_walk = 1e-4},
                               {.bias_instability = 1e-3},
                               {.rate_random_walk = 1e-4},
                               {.angle_random_walk = 1e-4, .markov_sd = 1e-2, .markov_time = 10.0}};
  for (const auto& model : models)
    for (unsigned seed = 1; seed <= 20; ++seed)
      for (const std::size_t samples : {1000u, 40000u})
        EXPECT_TRUE(parts_of(simulated(model, samples, seed)).empty()) << seed << " of " << samples;
}

TEST(DisturbedParts, AreTheTouchedBlocksAndOneMoreEitherWay) {
  EvenSignal signal = simulated({.angle_random_walk = 1e-4}, hour, 1);
  touch(1803.0, 5.0, 0.05, 1.0, signal.made);  // within the block from 1800 to 1809 s
  touch(3598.0, 2.0, 0.05, 1.0, signal.made);  // at the very end
  const auto parts = parts_of(signal);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].begin, 179100u);
  EXPECT_EQ(parts[0].end, 181800u);
  EXPECT_EQ(parts[1].end, hour);
  set_missing(parts, signal);
  EXPECT_TRUE(std::isnan(signal.values[180300]));
  EXPECT_FALSE(std::isnan(signal.values[179099]));
  EXPECT_TRUE(parts_of(signal).empty());
}

TEST(DisturbedParts, ARecordThatIsDisturbedThroughoutRemainsAsItIs) {
  EvenSignal signal = simulated({.angle_random_walk = 1e-4}, hour, 2);
  for (double begin = 50.0; begin < 3600.0; begin += 200.0) touch(begin, 5.0, 0.05, 1.0, signal.made);  // 18 x 27 s
  EXPECT_TRUE(parts_of(signal).empty());
}

TEST(DisturbedParts, HoldTheNoiseOfTouchedRecords) {
  // 3 to 10 s of motion of 50 sd of a sample in an hour. Of 42 intervals of 95 %, 4 sigma fewer than expected: 34. The
  // mean of 42 known to their sd/sqrt(42): 4 sigma.
  constexpr double n = 1e-4;
  constexpr int records = 42;
  int held = 0;
  double sum = 0.0, sd = 0.0;
  for (unsigned seed = 1; seed <= records; ++seed) {
    auto values = simulated({.angle_random_walk = n, .rate_random_walk = 2e-7}, hour, 100 + seed).made;
    touch(60.0 * seed + 0.7, 3.0 + seed / 6.0, 50.0 * n * std::sqrt(rate), 0.5 * (seed % 6 + 1), values);
    const Estimate estimate = identified(std::move(values), "cut");
    const Parameter* found = find_parameter(estimate, "gyro.x.angle_random_walk");
    ASSERT_NE(found, nullptr);
    const double u = standard_uncertainty(estimate, static_cast<std::size_t>(found - estimate.parameters.data()));
    EXPECT_LT(u, 0.004 * n);  // sqrt(1/(2 x 360 000)) = 0.12 %, and what the walk takes
    held += std::abs(found->value - n) < 1.98 * u ? 1 : 0;
    sum += found->value / n - 1.0;
    sd += u / n / records;
  }
  EXPECT_GE(held, 34);
  EXPECT_LT(std::abs(sum / records), 4.0 * sd / std::sqrt(1.0 * records));
}

TEST(DisturbedParts, AreSaidAndListedAndCanBeKept) {
  // 12 s: longer than the blocks of 9 s, so that it is no knock. It lies in blocks from 1800 to 1818 s, and one more
  // either way is excluded.
  auto values = simulated({.angle_random_walk = 1e-4}, hour, 3).made;
  touch(1803.0, 12.0, 0.05, 6.0, values);
  const Estimate cut = identified(values, "cut");
  EXPECT_EQ(finding_of(cut.findings, "parts_set_aside")->occurrences.count, 1u);
  EXPECT_NEAR(value_of(cut.findings, "parts_set_aside", "length"), 36.0, 1e-9);
  EXPECT_NEAR(value_of(cut.findings, "parts_set_aside", "from"), 1791.0, 1e-9);
  EXPECT_NEAR(value_of(cut.findings, "parts_set_aside", "to"), 1827.0, 1e-9);
  EXPECT_EQ(finding_of(cut.findings, "knocks_set_aside"), nullptr);
  const Table* table = find_table(cut, "set_aside");
  ASSERT_NE(table, nullptr);
  ASSERT_EQ(table->rows.size(), 1u);
  EXPECT_EQ(std::get<double>(table->rows[0][1]), 1791.0);
  EXPECT_EQ(std::get<double>(table->rows[0][3]), 36.0);
  const Estimate kept = identified(values, "keep");
  EXPECT_EQ(find_table(kept, "set_aside"), nullptr);
  EXPECT_TRUE(has_finding(kept.findings, "disturbed_blocks", {{"limit", 4.0}}));
}

TEST(DisturbedParts, AShortTouchIsExcludedAsAKnock) {
  auto values = simulated({.angle_random_walk = 1e-4}, hour, 3).made;
  touch(1803.0, 5.0, 0.05, 1.0, values);
  const Estimate cut = identified(values, "cut");
  EXPECT_EQ(finding_of(cut.findings, "parts_set_aside"), nullptr);
  EXPECT_NE(finding_of(cut.findings, "knocks_set_aside"), nullptr);
  const Table* table = find_table(cut, "set_aside");
  ASSERT_NE(table, nullptr);
  ASSERT_EQ(table->rows.size(), 1u);
  const double from = std::get<double>(table->rows[0][1]), length = std::get<double>(table->rows[0][3]);
  EXPECT_LT(from, 1803.0);
  EXPECT_GT(from + length, 1808.0);
  EXPECT_LT(length, 27.0);
}

}  // namespace
}  // namespace tumble::allan_noise
