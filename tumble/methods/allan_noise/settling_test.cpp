#include "tumble/methods/allan_noise/settling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tumble/math/noise_model.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/noise_record.hpp"

namespace tumble::allan_noise {
namespace {

constexpr double settling_rate = 10.0;
constexpr std::size_t settling_samples = 40000;

/// A gyro with a clear random walk.
std::vector<double> walking(const NoiseModel& noise, std::uint64_t seed) {
  std::vector<double> values(settling_samples, 0.0);
  add_noise(noise, settling_rate, RandomStream(seed), values);
  return values;
}

const NoiseModel white_and_walk{.angle_random_walk = si(0.9, "deg/sqrt(h)"),
                                .rate_random_walk = si(4.3, "deg/h/sqrt(h)")};

/// Whether the interval of the random walk holds the truth, or the walk is not shown.
bool holds_walk(const Estimate& estimate, const NoiseModel& truth) {
  const Parameter* walk = find_parameter(estimate, "gyro.x.rate_random_walk");
  if (walk == nullptr) return true;
  const auto index = static_cast<std::size_t>(walk - estimate.parameters.data());
  const double sd = standard_uncertainty(estimate, index);
  return std::abs(walk->value - truth.rate_random_walk) < 3.0 * sd;
}

TEST(WarmUp, IsNoRandomWalk) {
  for (const double time : {200.0, 600.0})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      auto values = walking(white_and_walk, seed);
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] += si(108.0, "deg/h") * (1.0 - std::exp(-static_cast<double>(i) / settling_rate / time));
      const Estimate estimate = identify_noise(noise_evidence(std::move(values), settling_rate));
      ASSERT_TRUE(has_finding(estimate.findings, "warm_up_subtracted")) << time << " " << seed;
      EXPECT_NEAR(value_of(estimate.findings, "warm_up_subtracted", "size"), -si(108.0, "deg/h"), si(25.0, "deg/h"));
      EXPECT_NEAR(value_of(estimate.findings, "warm_up_subtracted", "time") / time, 1.0, 0.5);
      EXPECT_TRUE(holds_walk(estimate, white_and_walk)) << time << " " << seed;
      EXPECT_NE(find_table(estimate, "settling"), nullptr);
    }
}

TEST(WarmUp, IsNotSaidOfNoise) {
  const NoiseModel models[] = {
      {.angle_random_walk = si(0.9, "deg/sqrt(h)")},
      white_and_walk,
      {.angle_random_walk = si(0.1, "deg/sqrt(h)"), .bias_instability = si(5.0, "deg/h")},
      {.angle_random_walk = si(0.1, "deg/sqrt(h)"), .rate_random_walk = si(200.0, "deg/h/sqrt(h)")}};
  int said = 0;
  for (const NoiseModel& model : models)
    for (std::uint64_t seed = 1; seed <= 25; ++seed)
      said += has_finding(identify_noise(noise_evidence(walking(model, 100 + seed), settling_rate)).findings,
                          "warm_up_subtracted");
  EXPECT_LE(said, 1);  // of 100 records: 0.3 on average
}

TEST(Temperature, OfManyCyclesIsNoRandomWalk) {
  const NoiseModel white{.angle_random_walk = si(0.1, "deg/sqrt(h)")};
  for (const double cycles : {3.0, 4.5, 8.0, 20.0}) {
    auto values = walking(white, 7);
    Channel temperature{
        "temperature", QuantityKind::temperature, Unit::parse("degC"), {0.0, settling_rate, nullptr}, {}};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double along = static_cast<double>(i) / static_cast<double>(values.size());
      // The cycles of a room are not regular.
      const double warmth = std::sin(2.0 * std::numbers::pi * (cycles * along + 0.4 * std::sin(7.0 * along) + 0.1));
      temperature.values.push_back(298.0 + warmth);
      values[i] += si(2.0, "deg/h") * warmth;
    }
    Channel gyro{
        "gyro.x", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, settling_rate, nullptr}, std::move(values)};
    const Estimate estimate = identify_noise(noise_evidence({std::move(gyro), std::move(temperature)}));
    EXPECT_TRUE(has_finding(estimate.findings, "output_follows_temperature")) << cycles;
    EXPECT_EQ(find_parameter(estimate, "gyro.x.rate_random_walk"), nullptr) << cycles;
    EXPECT_EQ(find_parameter(estimate, "gyro.x.bias_instability"), nullptr) << cycles;
  }
}

TEST(AllanNoise, FromLeavesTheBeginningOut) {
  auto values = walking(white_and_walk, 3);
  Evidence late = noise_evidence(std::vector<double>(values.begin() + 10000, values.end()), settling_rate);
  for (std::size_t i = 0; i < 10000; ++i) values[i] += si(500.0, "deg/h");
  Evidence whole = noise_evidence(std::move(values), settling_rate);
  whole.plan.settings.set_number("from", 1000.0, Unit::parse("s"));
  const Estimate one = identify_noise(whole), other = identify_noise(late);
  ASSERT_EQ(one.parameters.size(), other.parameters.size());
  for (std::size_t k = 0; k < one.parameters.size(); ++k)
    EXPECT_DOUBLE_EQ(one.parameters[k].value, other.parameters[k].value);
  whole.plan.settings.set_number("from", 4000.0, Unit::parse("s"));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "leaves nothing"}, [&] { identify_noise(whole); }));
}

TEST(AllanNoise, AnIncrementAfterALossIsNotDividedByOneInterval) {
  std::vector<double> angle{0.0}, white(settling_samples, 0.0);
  add_noise({.angle_random_walk = si(0.1, "deg/sqrt(h)")}, settling_rate, RandomStream(5), white);
  Channel steps{"angle", QuantityKind::angle, Unit::parse("arcsec"), {0.0, settling_rate, nullptr}, {}};
  double covered = 0.0;
  for (std::size_t i = 0; i < white.size(); ++i) {
    covered += (white[i] + si(100.0, "deg/h")) / settling_rate;  // a mean rate: the increment grows with the time
    const bool lost = i % 37 < 3;
    steps.values.push_back(lost ? std::nan("") : covered);
    if (!lost) covered = 0.0;
  }
  Evidence evidence = noise_evidence({std::move(steps)});
  evidence.plan.settings.set_word("data", "increment");
  EXPECT_NEAR(value(identify_noise(evidence), "angle.angle_random_walk") / si(0.1, "deg/sqrt(h)"), 1.0, 0.02);
}

TEST(AllanNoise, LimitsAreInTheUnitOfTheirChannel) {
  std::vector<Channel> channels;
  for (const auto& [name, kind, unit] : {std::tuple{"gyro.x", QuantityKind::angular_rate, "deg/h"},
                                         std::tuple{"accelerometer.x", QuantityKind::specific_force, "ug"}}) {
    channels.push_back({name, kind, Unit::parse(unit), {0.0, settling_rate, nullptr}, {}});
    channels.back().values.assign(4000, 0.0);
    add_noise({.angle_random_walk = 1e-4}, settling_rate, RandomStream(9).split(name), channels.back().values);
  }
  const Estimate estimate = identify_noise(noise_evidence(std::move(channels)));
  int limits = 0;
  for (const Finding& finding : estimate.findings) {
    if (finding.code != "noise_term_not_significant") continue;
    EXPECT_TRUE(finding.where == "gyro.x" || finding.where == "accelerometer.x") << finding.where;
    if (finding.message.find("bias_instability") == std::string::npos) continue;
    EXPECT_NE(finding.message.find(finding.where == "gyro.x" ? "deg/h" : "ug"), std::string::npos) << finding.message;
    ++limits;
  }
  EXPECT_EQ(limits, 2);
}

}  // namespace
}  // namespace tumble::allan_noise
