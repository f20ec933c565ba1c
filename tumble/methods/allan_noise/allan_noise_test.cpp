#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "tumble/math/noise_model.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/noise_record.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/reduce/even_signal.hpp"
#include "tumble/units/error.hpp"

namespace tumble::allan_noise {
namespace {

using Stamps = std::vector<double>;

/// White noise of N = 0.1 deg/sqrt(h), 10 Hz, 20 000 samples unless said.
Channel noisy(const std::string& name, std::uint64_t seed, std::size_t samples = 20000) {
  Channel channel{name, QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, 10.0, nullptr}, {}};
  channel.values.assign(samples, 0.0);
  add_noise({.angle_random_walk = si(0.1, "deg/sqrt(h)")}, 10.0, RandomStream(seed), channel.values);
  return channel;
}

Stamps even_stamps(std::size_t samples) {
  Stamps stamps;
  for (std::size_t i = 0; i < samples; ++i) stamps.push_back(0.1 * static_cast<double>(i));
  return stamps;
}

void stamp(Channel& channel, Stamps stamps) {
  channel.timeline = {0.0, 0.0, std::make_shared<const Stamps>(std::move(stamps))};
}

/// N within 5 standard uncertainties of the truth.
void expect_white(const Estimate& estimate, const std::string& channel) {
  const Parameter* n = find_parameter(estimate, channel + ".angle_random_walk");
  ASSERT_NE(n, nullptr) << channel;
  const double sd = standard_uncertainty(estimate, static_cast<std::size_t>(n - estimate.parameters.data()));
  EXPECT_NEAR(n->value, si(0.1, "deg/sqrt(h)"), 5.0 * sd);
  EXPECT_LT(sd, 0.02 * n->value);
}

TEST(AllanNoise, TakesEveryInertialChannelOrTheSignal) {
  Channel temperature{"temperature", QuantityKind::temperature, Unit::parse("degC"), {0.0, 1.0, nullptr}, {300, 301}};
  auto evidence = noise_evidence({noisy("gyro.x", 1), temperature, noisy("gyro.y", 2)});
  const auto both = identify_noise(evidence);
  expect_white(both, "gyro.x");
  expect_white(both, "gyro.y");
  evidence.plan.channels["signal"] = {{"gyro.y", {}}};
  const auto one = identify_noise(evidence);
  EXPECT_EQ(find_parameter(one, "gyro.x.angle_random_walk"), nullptr);
  expect_white(one, "gyro.y");
}

TEST(AllanNoise, SkipsAStuckChannelAndSaysSo) {
  Channel stuck = noisy("gyro.z", 3);
  stuck.values.assign(stuck.values.size(), 0.25);
  const auto estimate = identify_noise(noise_evidence({noisy("gyro.x", 1), stuck}));
  expect_white(estimate, "gyro.x");
  const Finding* skipped = finding_of(estimate.findings, "channel_not_analysed");
  ASSERT_NE(skipped, nullptr);
  EXPECT_EQ(skipped->where, "gyro.z");
  EXPECT_EQ(skipped->severity, Finding::Severity::error);
  EXPECT_NE(skipped->message.find("does not change"), std::string::npos) << skipped->message;
}

TEST(AllanNoise, LostSamplesBecomeMissingSamples) {
  Channel gapped = noisy("gyro.x", 4);
  Stamps stamps = even_stamps(gapped.values.size());
  for (std::size_t i = 7000; i < stamps.size(); ++i) stamps[i] += 12.3;
  stamp(gapped, stamps);
  const auto signal = even_signal({&gapped, "gyro.x", 0, gapped.values.size()}, 0.0, "auto");
  // 12.3 s are 123 samples at 10 Hz, to the one that rounding of the last stamp adds or drops.
  EXPECT_NEAR(static_cast<double>(signal.values.size()), 20123.0, 1.0);
  EXPECT_TRUE(std::isnan(signal.values[7050]));
  EXPECT_EQ(signal.values[6999], gapped.values[6999]);
  ASSERT_EQ(signal.findings.size(), 1u);
  const auto estimate = identify_noise(noise_evidence({gapped}));
  expect_white(estimate, "gyro.x");
  EXPECT_TRUE(std::ranges::any_of(estimate.findings, [&](const Finding& finding) {
    return finding.where == "gyro.x" && finding.message == signal.findings[0].message;
  }));
}

// One finding for a term that several channels do not show: where, and the greatest of their limits.
TEST(AllanNoise, ATermThatNoChannelShowsIsOneFinding) {
  const auto estimate = identify_noise(noise_evidence({noisy("gyro.x", 1), noisy("gyro.y", 2)}));
  std::size_t terms = 0;
  for (const Finding& finding : estimate.findings) {
    if (finding.code != "noise_term_not_significant") continue;
    ++terms;
    EXPECT_EQ(finding.where, "gyro.x, gyro.y");
    EXPECT_EQ(finding.occurrences.count, 2u);
    EXPECT_EQ(finding.occurrences.first.label, "gyro.x");
    EXPECT_EQ(finding.values[1].name, "limit");
    EXPECT_GT(std::get<double>(finding.values[1].value), 0.0);
  }
  EXPECT_GE(terms, 3u);  // all but the white noise
}

TEST(AllanNoise, RefusesABackwardClockAndNamesTheTime) {
  Channel backward = noisy("gyro.x", 5);
  Stamps stamps = even_stamps(backward.values.size());
  for (std::size_t i = 5000; i < stamps.size(); ++i) stamps[i] -= 100.0;
  stamp(backward, stamps);
  auto evidence = noise_evidence({backward});
  try {
    identify_noise(evidence);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_data);
    EXPECT_NE(std::string(error.what()).find("400 s"), std::string::npos) << error.what();
  }
  evidence.plan.settings.set_number("rate", 10.0, Unit::parse("Hz"));
  expect_white(identify_noise(evidence), "gyro.x");
}

TEST(AllanNoise, StampsOnAGridAverageWhatFallsTogether) {
  Channel channel{"g", QuantityKind::angular_rate, Unit::parse("rad/s"), {}, {}};
  Stamps stamps;
  for (int i = 0; i < 40; ++i) {
    stamps.push_back(i + (i % 2 == 0 ? 0.2 : -0.2));
    channel.values.push_back(i);
  }
  stamp(channel, stamps);
  const auto signal = even_signal({&channel, "g", 0, 40}, 0.0, "stamps");
  ASSERT_GE(signal.values.size(), 38u);
  double sum = 0.0;
  for (const double value : signal.values) sum += std::isnan(value) ? 0.0 : 1.0;
  EXPECT_GT(sum, 30.0);
}

TEST(AllanNoise, SeveralPowerUpsAreSeveralRecords) {
  auto evidence = noise_evidence({noisy("gyro.x", 6)});
  evidence.recordings[0].marks = {{"first", 0.0, 1}, {"second", 900.0, 2}};
  const auto estimate = identify_noise(evidence);
  EXPECT_NE(find_parameter(estimate, "gyro.x.angle_random_walk"), nullptr);
  EXPECT_NE(find_parameter(estimate, "gyro.x.run2.angle_random_walk"), nullptr);
}

TEST(AllanNoise, DistinguishesARampFromNoise) {
  // White noise over T = 2000 s: sd of the slope sqrt(12/T^3) N = 0.84 deg/h/h, and more for the random walk that may
  // hide. A clear ramp stays and leaves N and nothing else, none is seen without. 5 sd: 1 in 10^6.
  Channel ramped = noisy("gyro.x", 8);
  const double slope = si(-60.0, "deg/h/h");
  for (std::size_t i = 0; i < ramped.values.size(); ++i) ramped.values[i] += slope * 0.1 * static_cast<double>(i);
  const auto estimate = identify_noise(noise_evidence({ramped, noisy("gyro.y", 8)}));
  expect_white(estimate, "gyro.x");
  EXPECT_EQ(find_parameter(estimate, "gyro.x.rate_random_walk"), nullptr);
  EXPECT_EQ(find_parameter(estimate, "gyro.y.rate_ramp"), nullptr);
  const Parameter* ramp = find_parameter(estimate, "gyro.x.rate_ramp");
  ASSERT_NE(ramp, nullptr);
  const double sd = standard_uncertainty(estimate, static_cast<std::size_t>(ramp - estimate.parameters.data()));
  EXPECT_GT(sd, 0.98 * si(0.1, "deg/sqrt(h)") * std::sqrt(12.0 / 8e9));
  EXPECT_LT(sd, -slope / 3.0);
  EXPECT_NEAR(ramp->value, slope, 5.0 * sd);
}

TEST(AllanNoise, PointsAtMotionAndSettingsThatExcludeEachOther) {
  Channel moved = noisy("gyro.x", 7);
  for (std::size_t i = 9000; i < 9040; ++i) moved.values[i] += si(100.0, "deg/s");
  EXPECT_TRUE(says(identify_noise(noise_evidence({moved})).findings, "motion"));
  auto evidence = noise_evidence({noisy("gyro.x", 1)});
  evidence.plan.settings.set_number("points_per_decade", 0.5, Unit());
  evidence.plan.settings.set_integer("windows", 2);
  try {
    identify_noise(evidence);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_input);
    EXPECT_EQ(error.problems.size(), 2u);
  }
}

const Curve* curve_named(const Estimate& estimate, const std::string& name) {
  for (const auto& curve : estimate.curves)
    if (curve.name == name) return &curve;
  return nullptr;
}

TEST(AllanNoise, TheSpectrumOfAFilteredSensorFallsAsItIsMeasured) {
  // At half the rate the density is a fifth of that at frequency zero, which was drawn before.
  Trial trial = second_trial_of(find_method("allan_noise"), 5);
  trial.evidence.plan.settings.set_word("spectrum", "welch");
  const auto estimate = identify_noise(trial.evidence);
  const Curve* spectrum = curve_named(estimate, "accelerometer.z power_spectrum");
  const Curve* white = curve_named(estimate, "accelerometer.z velocity_random_walk_density");
  ASSERT_NE(spectrum, nullptr);
  ASSERT_NE(white, nullptr);
  EXPECT_LT(white->y.values.back(), 0.4 * white->y.values.front());
  // As in the test below 15 %, and 4 sd of N and of the filter, which make 2.5 % there.
  EXPECT_NEAR(spectrum->y.values.back(), white->y.values.back(), 0.25 * white->y.values.back());
}

// A low pass of 0.16 Hz and a process of 1 s are the same noise; with white noise of its own size beside it, it is a
// process.
TEST(AllanNoise, AProcessThatMayBeAFilterIsSaid) {
  for (const double white : {0.0, 1.0}) {
    const RandomStream random(31);
    Channel gyro{"gyro", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, 10.0, nullptr}, {}};
    const double kept = std::exp(-0.1), size = si(4.0, "deg/h");
    double state = 0.0;
    for (std::uint64_t i = 0; i < 20'000; ++i) {
      state = kept * state + std::sqrt(1.0 - kept * kept) * random.normal(2 * i);
      gyro.values.push_back(size * (state + white * random.normal(2 * i + 1)));
    }
    const auto estimate = identify_noise(noise_evidence({gyro}));
    const auto said = std::ranges::find(estimate.findings, "process_like_filter", &Finding::code);
    EXPECT_EQ(said != estimate.findings.end(), white == 0.0) << white;
    if (white > 0.0 || said == estimate.findings.end()) continue;
    const auto density = std::ranges::find(said->values, "density", &FindingValue::name);
    // 2 s^2 T of 1 s from 2000 s: 4 sd of about 4 %
    EXPECT_NEAR(std::get<double>(density->value), size * std::sqrt(2.0), 0.16 * size * std::sqrt(2.0));
  }
}

TEST(AllanNoise, ShowsTheSpectrumAndEveryAveragingTimeWhereAsked) {
  auto evidence = noise_evidence({noisy("gyro.x", 11, 4000)});
  EXPECT_EQ(curve_named(identify_noise(evidence), "gyro.x power_spectrum"), nullptr);
  evidence.plan.settings.set_word("spectrum", "welch");
  evidence.plan.settings.set_word("taus", "all");
  evidence.plan.settings.set_integer("windows", 5);
  const auto estimate = identify_noise(evidence);
  const Curve* spectrum = curve_named(estimate, "gyro.x power_spectrum");
  const Curve* white = curve_named(estimate, "gyro.x angle_random_walk_density");
  ASSERT_NE(spectrum, nullptr);
  ASSERT_NE(white, nullptr);
  // One-sided: 2 N^2. Points of the last tenth of a decade average 160 frequencies: 3.6 % and 4 sd.
  EXPECT_NEAR(spectrum->y.values.back(), white->y.values.back(), 0.15 * white->y.values.back());
  EXPECT_NEAR(white->y.values.back(), 2.0 * std::pow(si(0.1, "deg/sqrt(h)"), 2), 0.1 * white->y.values.back());
  const Curve* every = curve_named(estimate, "gyro.x every_averaging_time");
  const Curve* points = curve_named(estimate, "gyro.x allan_deviation");
  ASSERT_NE(every, nullptr);
  ASSERT_EQ(every->x.values.size(), 1000u);
  const double tau = points->x.values.back();
  const std::size_t at = static_cast<std::size_t>(std::llround(10.0 * tau)) - 1;
  EXPECT_NEAR(every->y.values[at], points->y.values.back(), 1e-9 * points->y.values.back());
  EXPECT_NEAR(every->lower[at], points->lower.back(), 1e-9 * points->lower.back());
  EXPECT_EQ(find_table(estimate, "windows")->rows.size() % 5, 0u);
  EXPECT_EQ(finding_of(estimate.findings, "deviation_changes_along_record"), nullptr);
  EXPECT_EQ(finding_of(estimate.findings, "noise_changes_along_record"), nullptr);
}

TEST(AllanNoise, DistinguishesInstrumentsThatMeasureTheSame) {
  // Three gyros of N = 0.1 deg/sqrt(h) on a moving base. What two have in common is found, the third keeps out of it.
  std::vector<Channel> gyros{noisy("a", 21), noisy("b", 22), noisy("c", 23)};
  std::vector<double> motion(gyros[0].values.size(), 0.0);
  add_noise({.rate_random_walk = si(200.0, "deg/h/sqrt(h)")}, 10.0, RandomStream(24), motion);
  for (auto& gyro : gyros)
    for (std::size_t i = 0; i < motion.size(); ++i) gyro.values[i] += motion[i];
  auto evidence = noise_evidence(gyros);
  evidence.plan.settings.set_flag("hat", true);
  const Curve* alone = nullptr;
  const auto hat = identify_noise(evidence);
  ASSERT_NE(alone = curve_named(hat, "b by itself"), nullptr);
  for (std::size_t i = 0; i < 6; ++i) {  // edf above 300: sd of the deviation below 10 %
    const double truth = si(0.1, "deg/sqrt(h)") / std::sqrt(alone->x.values[i]);
    EXPECT_NEAR(alone->y.values[i], truth, 0.3 * truth);
  }
  std::vector<Channel> supplied{noisy("a", 21), noisy("b", 22), noisy("c", 23)};
  for (std::size_t i = 0; i < motion.size(); ++i) supplied[1].values[i] += 0.2 * supplied[0].values[i];
  evidence = noise_evidence(supplied);
  evidence.plan.settings.set_flag("correlation", true);
  const auto together = identify_noise(evidence);
  const Finding* correlated = finding_of(together.findings, "channels_correlated");
  ASSERT_NE(correlated, nullptr);
  EXPECT_EQ(correlated->where, "a, b");
  EXPECT_EQ(correlated->occurrences.count, 1u);
  // 0.2/sqrt(1 + 0.2^2), with about 20 000 differences: sd 0.007
  EXPECT_NEAR(value_of(together.findings, "channels_correlated", "correlation"), 0.196, 0.035);
}

TEST(AllanNoise, SaysHowChannelsFollowTheTemperature) {
  // Two cycles of 3 K over 2000 s; 5 deg/h/K on one gyro, none on the other. Nothing is said where it does not move.
  std::vector<Channel> channels{noisy("gyro.x", 31), noisy("gyro.y", 32)};
  Channel temperature{"temperature", QuantityKind::temperature, Unit::parse("degC"), {0.0, 10.0, nullptr}, {}};
  temperature.values.assign(channels[0].values.size(), 298.0);
  auto still = noise_evidence(channels);
  still.recordings[0].channels.push_back(temperature);
  EXPECT_EQ(find_table(identify_noise(still), "temperature"), nullptr);
  for (std::size_t i = 0; i < temperature.values.size(); ++i) {
    const double warmth = 3.0 * std::sin(std::numbers::pi * 2e-4 * static_cast<double>(i));
    temperature.values[i] += warmth;
    channels[0].values[i] += si(5.0, "deg/h") * warmth;
  }
  channels.push_back(temperature);
  const auto estimate = identify_noise(noise_evidence(channels));
  const Table* table = find_table(estimate, "temperature");
  ASSERT_NE(table, nullptr);
  ASSERT_EQ(table->rows.size(), 2u);
  EXPECT_NEAR(std::get<double>(table->rows[0][2]), 6.0, 0.1);
  EXPECT_NEAR(std::stod(std::get<std::string>(table->rows[0][3])), 5.0, 0.2);
  const Finding* follows = finding_of(estimate.findings, "output_follows_temperature");
  ASSERT_NE(follows, nullptr);
  EXPECT_EQ(follows->where, "gyro.x");
  EXPECT_NEAR(value_of(estimate.findings, "output_follows_temperature", "slope"), si(5.0, "deg/h/K"),
              si(0.2, "deg/h/K"));
  EXPECT_EQ(std::ranges::count(estimate.findings, "output_follows_temperature", &Finding::code), 1);
}

}  // namespace
}  // namespace tumble::allan_noise
