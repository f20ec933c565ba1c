#include "tumble/methods/allan_noise/outliers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tumble/math/noise_model.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/noise_record.hpp"

namespace tumble::allan_noise {
namespace {

constexpr double sampled = 100.0;
constexpr std::size_t records_samples = 60000;

/// White noise, sd of a sample 1e-4 rad/s.
Channel white_channel(const std::string& name, std::uint64_t seed) {
  Channel channel{name, QuantityKind::angular_rate, Unit::parse("rad/s"), {0.0, sampled, nullptr}, {}};
  channel.values.assign(records_samples, 0.01);
  add_noise({.angle_random_walk = 1e-5}, sampled, RandomStream(seed), channel.values);
  return channel;
}

/// A knock that rings: 5 Hz, gone in a second.
void knock(double at, double height, std::vector<double>& values) {
  const auto first = static_cast<std::size_t>(at * sampled);
  for (std::size_t i = 0; i < 500; ++i) {
    const double t = static_cast<double>(i) / sampled;
    values[first + i] += height * std::exp(-t / 0.3) * std::cos(2.0 * std::numbers::pi * 5.0 * t);
  }
}

const Parameter& walk_of(const Estimate& estimate, const std::string& channel) {
  const Parameter* n = find_parameter(estimate, channel + ".angle_random_walk");
  if (n == nullptr) throw std::runtime_error("no angle random walk of " + channel);
  return *n;
}

/// In its stated standard uncertainties.
double off_by(const Estimate& estimate, const std::string& channel, double truth) {
  const Parameter& n = walk_of(estimate, channel);
  return (n.value - truth) / standard_uncertainty(estimate, static_cast<std::size_t>(&n - estimate.parameters.data()));
}

const Table* table_named(const Estimate& estimate, const std::string& name) {
  const auto found = std::ranges::find(estimate.tables, name, &Table::name);
  return found == estimate.tables.end() ? nullptr : &*found;
}

TEST(Outliers, NoneInNoiseOfAnyColour) {
  const NoiseModel models[] = {{.angle_random_walk = 1e-4},
                               {.quantization_noise = 1e-4},
                               {.bias_instability = 1e-3},
                               {.rate_random_walk = 1e-3},
                               {.angle_random_walk = 1e-4, .bias_instability = 1e-3, .rate_random_walk = 1e-4}};
  for (const auto& model : models)
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      std::vector<double> values(20000, 1.0);
      add_noise(model, sampled, RandomStream(seed), values);
      OutlierSearch search;
      search.push(values);
      EXPECT_TRUE(search.events().empty()) << seed;
    }
}

TEST(Outliers, DoNotDependOnThePieces) {
  auto channel = white_channel("gyro.x", 3);
  knock(200.0, 2e-3, channel.values);
  channel.values[7] += 5e-3;
  channel.values[59990] -= 5e-3;
  OutlierSearch whole, pieces;
  whole.push(channel.values);
  for (std::size_t first = 0; first < channel.values.size(); first += 1001)
    pieces.push(std::span(channel.values).subspan(first, std::min<std::size_t>(1001, channel.values.size() - first)));
  const auto one = whole.events(), other = pieces.events();
  ASSERT_EQ(one.size(), 3u);
  ASSERT_EQ(other.size(), 3u);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].begin, other[i].begin);
  EXPECT_EQ(one[0].worst, 7u);
  EXPECT_FALSE(is_knock(one[0]));
  EXPECT_TRUE(is_knock(one[1]));
  EXPECT_EQ(one[2].worst, 59990u);
}

TEST(Outliers, ARingingKnockIsNamedWithItsTimeOnAllChannelsAndExcluded) {
  // 48 sd on one channel, half of it on the other. N without it within 4 of its sd; with it, it was 0.7 % and more off.
  auto x = white_channel("gyro.x", 1), y = white_channel("gyro.y", 2);
  knock(200.0, 4.8e-3, x.values);
  knock(200.0, 2.4e-3, y.values);
  const auto estimate = identify_noise(noise_evidence({x, y}));
  const Finding* finding = finding_of(estimate.findings, "knocks_set_aside");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->occurrences.count, 1u);
  EXPECT_NEAR(finding->occurrences.worst.time, 200.0, 0.5);
  EXPECT_EQ(std::get<std::string>(finding->values[2].value), "gyro.x, gyro.y");
  const Table* table = table_named(estimate, "knocks");
  ASSERT_NE(table, nullptr);
  EXPECT_EQ(table->rows.size(), 1u);
  for (const char* name : {"gyro.x", "gyro.y"}) {
    EXPECT_LT(std::abs(off_by(estimate, name, 1e-5)), 4.0) << name;
    EXPECT_EQ(walk_of(estimate, name).degrees_of_freedom > 1000.0, true) << name;  // hardly anything was excluded
  }
}

TEST(Outliers, FivePerCentAreCountedWithTheTermsWithoutThemBeside) {
  // 5 % of the samples with 10 times the sd: the record's own N is sqrt(1 + 0.05 100) = 2.449 times that of the others,
  // its sd 4.6 times that of Gaussian noise. Outliers below 4 to 5 sd remain: 7 % of N.
  int held = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    auto channel = white_channel("gyro.x", seed);
    const auto stream = RandomStream(seed).split("outliers");
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      if (stream.uniform(2 * i) < 0.05) channel.values[i] += 1e-3 * stream.split("size").normal(i);
    const auto estimate = identify_noise(noise_evidence({channel}));
    held += std::abs(off_by(estimate, "gyro.x", 1e-5 * std::sqrt(6.0))) < 1.96 ? 1 : 0;
    const Finding* finding = finding_of(estimate.findings, "outliers_change_terms");
    ASSERT_NE(finding, nullptr);
    const double without = std::get<double>(finding->values[4].value);
    EXPECT_EQ(finding->values[4].name, "without");
    EXPECT_NEAR(without / 1e-5, 1.0, 0.10);
    EXPECT_EQ(finding_of(estimate.findings, "knocks"), nullptr);
    EXPECT_EQ(finding_of(estimate.findings, "knocks_set_aside"), nullptr);
    const Table* table = table_named(estimate, "robust");
    ASSERT_NE(table, nullptr);
    EXPECT_GT(std::get<double>(table->rows[0].back()), 0.02 * static_cast<double>(records_samples));
  }
  EXPECT_GE(held, 15);  // 19 less 4 sd of the binomial distribution
}

TEST(Outliers, SoundRecordsAreNotAccused) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto estimate = identify_noise(noise_evidence({white_channel("gyro.x", seed)}));
    for (const Finding& finding : estimate.findings)
      EXPECT_TRUE(finding.code == "noise_term_not_significant") << finding.code << " " << seed;
    EXPECT_EQ(table_named(estimate, "robust"), nullptr);
  }
}

}  // namespace
}  // namespace tumble::allan_noise
