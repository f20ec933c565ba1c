#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/static_bias/averages.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::static_bias {
namespace {

const std::vector<UnitTerm> terms{{NoiseTerm::white}, {NoiseTerm::flicker}, {NoiseTerm::random_walk}};

Evidence at_rest(const NoiseModel& noise, double bias, std::size_t samples, std::uint64_t seed) {
  Channel gyro{"gyro", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, 1.0, nullptr}, {}};
  gyro.values.assign(samples, bias);
  add_noise(noise, 1.0, RandomStream(seed), gyro.values);
  Evidence evidence;
  evidence.plan.method = "static_bias";
  evidence.plan.settings = defaults(find_method("static_bias").options());
  evidence.recordings.emplace_back();
  evidence.recordings.back().channels.push_back(gyro);
  return evidence;
}

TEST(StaticBias, ExpectedScatterOfAveragesAgreesWithSimulation) {
  const NoiseModel noise{.angle_random_walk = 1.0, .bias_instability = 0.2, .rate_random_walk = 0.02};
  const std::size_t samples = 3000, records = 800;
  const auto expected = expected_scatter(terms, {1.0, 0.04, 4e-4}, samples, 10, 10);
  std::vector<double> s, l;
  for (std::size_t seed = 0; seed < records; ++seed) {
    std::vector<double> rate(samples, 0.0);
    add_noise(noise, 1.0, RandomStream(3000 + seed), rate);
    s.push_back(scatter_of_averages(rate, 10).variance);
    l.push_back(scatter_of_averages(rate, 100).variance);
  }
  const auto mean = [](const std::vector<double>& v) {
    double sum = 0.0;
    for (const double x : v) sum += x / static_cast<double>(v.size());
    return sum;
  };
  const auto products = [&](const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> p;
    for (std::size_t i = 0; i < a.size(); ++i) p.push_back((a[i] - mean(a)) * (b[i] - mean(b)));
    return p;
  };
  // 4 standard errors of each mean, from the scatter of what is averaged.
  const auto near = [&](const std::vector<double>& v, double value) {
    const double error = std::sqrt(mean(products(v, v)) / static_cast<double>(v.size()));
    EXPECT_NEAR(mean(v), value, 4.0 * error);
  };
  near(s, expected.shorter);
  near(l, expected.longer);
  near(products(s, s), expected.shorter_variance);
  near(products(l, l), expected.longer_variance);
  near(products(s, l), expected.covariance);
}

TEST(StaticBias, VarianceOfTheMeanAgreesWithSimulation) {
  for (const NoiseModel& noise : {NoiseModel{.quantization_noise = 1.0}, NoiseModel{.angle_random_walk = 1.0},
                                  NoiseModel{.bias_instability = 1.0}, NoiseModel{.rate_random_walk = 1.0}}) {
    const UnitTerm term{noise.quantization_noise > 0.0  ? NoiseTerm::quantization
                        : noise.angle_random_walk > 0.0 ? NoiseTerm::white
                        : noise.bias_instability > 0.0  ? NoiseTerm::flicker
                                                        : NoiseTerm::random_walk};
    const std::size_t samples = 500, records = 1000;
    double squares = 0.0;
    for (std::size_t seed = 0; seed < records; ++seed) {
      std::vector<double> rate(samples, 0.0);
      add_noise(noise, 1.0, RandomStream(60000 + seed), rate);
      double mean = 0.0;
      for (const double value : rate) mean += value / static_cast<double>(samples);
      squares += mean * mean / static_cast<double>(records);
    }
    // A variance of 1000 normal means: 4 sigma are 4 sqrt(2/1000) = 18 %.
    EXPECT_NEAR(squares / mean_variance(term, samples), 1.0, 0.18) << static_cast<int>(term.term);
  }
}

TEST(StaticBias, OneRunHoldsTheConstantAtPowerOn) {
  // Flicker and random walk since power-on outweigh the white noise in the mean by far: N/sqrt(T) = 0.022, the two
  // others 0.43 together. 300 seeds: 0.95 +- 4 sqrt(0.95 0.05/300).
  const NoiseModel noise{.angle_random_walk = 1.0, .bias_instability = 0.3, .rate_random_walk = 0.01};
  int inside = 0;
  double mean_z = 0.0;
  const int seeds = 300;
  for (int seed = 0; seed < seeds; ++seed) {
    const auto estimate = find_method("static_bias").identify(at_rest(noise, 5.0, 2000, 9000 + seed), {});
    const double sd = standard_uncertainty(estimate, 0), error = estimate.parameters[0].value - 5.0;
    ASSERT_EQ(estimate.parameters[0].name, "bias");
    inside += std::abs(error) <= student_quantile(0.975, estimate.parameters[0].degrees_of_freedom) * sd;
    mean_z += error / sd / seeds;
  }
  EXPECT_NEAR(inside / static_cast<double>(seeds), 0.95, 4.0 * std::sqrt(0.95 * 0.05 / seeds));
  EXPECT_NEAR(mean_z, 0.0, 4.0 / std::sqrt(seeds));
}

/// Half width of the interval of one run, over that of a normal number with the scatter of the errors, and the share
/// that holds the truth.
struct OneRun {
  double width = 0.0, held = 0.0;
};

OneRun one_run(const NoiseModel& noise, int seeds) {
  double squares = 0.0, widths = 0.0, inside = 0.0;
  for (int seed = 0; seed < seeds; ++seed) {
    const auto estimate = find_method("static_bias").identify(at_rest(noise, 5.0, 1500, 40000 + seed), {});
    const double error = estimate.parameters[0].value - 5.0;
    const double width =
        student_quantile(0.975, estimate.parameters[0].degrees_of_freedom) * standard_uncertainty(estimate, 0);
    squares += error * error / seeds;
    widths += width / seeds;
    inside += std::abs(error) <= width ? 1.0 / seeds : 0.0;
  }
  return {widths / 1.96 / std::sqrt(squares), inside};
}

// One record shows slow noise badly: the interval is wider than if the noise were known, by four at most (the scatter
// of 100 errors is known to 7 %, 4 sigma 28 %), and where slow noise leads by less. It holds in 95 % or more: 4 sigma
// of 100 are 0.087.
TEST(StaticBiasCoverage, OneRunIsNeitherTooNarrowNorTenTimesTooWide) {
  const OneRun white = one_run({.angle_random_walk = 1.0}, 100),
               walk = one_run({.angle_random_walk = 1.0, .rate_random_walk = 0.01}, 100);
  EXPECT_LT(white.width, 4.0 * 1.28);
  EXPECT_LT(walk.width, 2.0 * 1.28);
  EXPECT_GT(white.held, 0.95 - 0.087);
  EXPECT_GT(walk.held, 0.95 - 0.087);
}

// Three runs of a slow instrument whose means differ by 0.25 mg: less than its noise within the runs could do. The
// limit of the repeatability is at least their scatter, and not zero.
TEST(StaticBias, LimitOfTheRepeatabilityIsAboveTheScatterOfTheRuns) {
  Evidence evidence;
  evidence.plan.settings = defaults(find_method("static_bias").options());
  const NoiseModel noise{.angle_random_walk = si(20.0, "ug"), .rate_random_walk = si(100.0, "ug")};
  const double levels[] = {0.0, si(0.25, "mg"), si(0.1, "mg")};
  for (std::uint64_t run = 0; run < 3; ++run) {
    Channel channel{"a", QuantityKind::specific_force, Unit::parse("m/s^2"), {0.0, 1.0, nullptr}, {}};
    channel.values.assign(2000, 0.0);
    add_noise(noise, 1.0, RandomStream(77 + run), channel.values);
    double mean = 0.0;
    for (const double v : channel.values) mean += v / 2000.0;
    for (double& v : channel.values) v += levels[run] - mean;
    evidence.recordings.emplace_back();
    evidence.recordings.back().channels.push_back(channel);
  }
  const auto estimate = find_method("static_bias").identify(evidence, {});
  ASSERT_EQ(find_parameter(estimate, "turn_on_repeatability"), nullptr);
  const double scatter = si(0.1258, "mg");  // of the three levels
  EXPECT_GT(value_of(estimate.findings, "not_significant", "limit"), scatter);
}

// With several runs every interval of a standard deviation stays above zero. That of a repeatability, the excess of a
// scatter over another, begins at zero where the runs differ no more than chance allows.
TEST(StaticBias, IntervalsOfStandardDeviationsAreAboveZero) {
  for (const Trial& trial : {trial_of(find_method("static_bias"), 1), second_trial_of(find_method("static_bias"), 1)}) {
    const auto estimate = find_method("static_bias").identify(trial.evidence, {});
    for (const char* name : {"bias_sd_10s", "bias_sd_100s", "turn_on_repeatability"}) {
      const Parameter* sd = find_parameter(estimate, name);
      ASSERT_NE(sd, nullptr) << name;
      EXPECT_GE(sd->lower, 0.0) << name;
      if (std::string(name) != "turn_on_repeatability") {
        EXPECT_GT(sd->lower, 0.0) << name;
      }
      EXPECT_LT(sd->lower, sd->value) << name;
      EXPECT_GT(sd->upper, sd->value) << name;
    }
  }
}

TEST(StaticBias, SubtractsTheRateOfTheEarth) {
  auto evidence = at_rest({.angle_random_walk = si(0.001, "deg/sqrt(h)")}, 0.0, 2000, 1);
  const double latitude = 0.6;
  for (double& value : evidence.recordings[0].channels[0].values) value += 7.292115e-5 * std::sin(latitude);
  evidence.plan.site = Site{latitude, 0.0, 0.0, {}};
  evidence.plan.settings.set_word("axis", "up");
  const auto up = find_method("static_bias").identify(evidence, {});
  EXPECT_NEAR(up.parameters[0].value, 0.0, 5.0 * standard_uncertainty(up, 0));
  evidence.plan.settings.set_word("axis", "down");
  const auto down = find_method("static_bias").identify(evidence, {});
  EXPECT_NEAR(down.parameters[0].value, 2.0 * 7.292115e-5 * std::sin(latitude), 5.0 * standard_uncertainty(down, 0));
}

/// The line of the budget of this source; null: none.
const Contribution* line_of(const Estimate& estimate, const std::string& source) {
  const auto found = std::ranges::find(estimate.budget, source, &Contribution::source);
  return found == estimate.budget.end() ? nullptr : &*found;
}

// What is subtracted is known no better than the site: normal gravity without a height is 318 ug, normal gravity at a
// height 50 ug, a measured one 5 ug, and 10 arcsec of latitude move the Earth's rate by w_ie sin or cos of it.
TEST(StaticBias, WhatIsSubtractedBringsItsUncertainty) {
  Evidence evidence = second_trial_of(find_method("static_bias"), 1).evidence;
  Site& site = *evidence.plan.site;
  const double measured = *site.gravity;
  const auto sd_of = [&] {
    const auto estimate = find_method("static_bias").identify(evidence, {});
    const Contribution* line = line_of(estimate, "gravity");
    EXPECT_NE(line, nullptr);
    return line ? std::pair(line->factor(0, 0), line->key) : std::pair(0.0, std::string());
  };
  EXPECT_NEAR(sd_of().first, si(5.0, "ug"), 1e-12);  // "down": a greater gravity takes more from the bias
  EXPECT_EQ(sd_of().second, "gravity 9.79684 m/s^2");
  site.gravity.reset();
  EXPECT_NEAR(sd_of().first, si(318.7, "ug"), si(0.5, "ug"));
  site.height = 30.0;
  EXPECT_NEAR(sd_of().first, si(50.0, "ug"), 1e-12);
  evidence.plan.settings.set_word("axis", "north");  // gravity has no part along it
  EXPECT_EQ(line_of(find_method("static_bias").identify(evidence, {}), "gravity"), nullptr);
  site.gravity = measured;

  auto gyro = at_rest({.angle_random_walk = si(0.001, "deg/sqrt(h)")}, 0.0, 2000, 1);
  gyro.plan.site = Site{.latitude = 0.6};
  const double ten_arcsec = si(10.0, "arcsec");
  for (const auto& [axis, slope] :
       {std::pair{"up", -std::cos(0.6)}, std::pair{"north", std::sin(0.6)}, std::pair{"south", -std::sin(0.6)}}) {
    gyro.plan.settings.set_word("axis", axis);
    const auto estimate = find_method("static_bias").identify(gyro, {});
    const Contribution* line = line_of(estimate, "latitude");
    ASSERT_NE(line, nullptr) << axis;
    EXPECT_NEAR(line->factor(0, 0), slope * 7.292115e-5 * ten_arcsec, 1e-15) << axis;
  }
}

TEST(StaticBias, NamesTheFileOfEachPowerUp) {
  auto evidence = at_rest({.angle_random_walk = 1.0}, 0.0, 2000, 1);
  evidence.recordings.push_back(evidence.recordings[0]);
  evidence.recordings[0].origin.file = "monday.csv";
  evidence.recordings[1].origin.file = "tuesday.csv";
  for (double& value : evidence.recordings[1].channels[0].values) value += 0.5;
  const auto estimate = find_method("static_bias").identify(evidence, {});
  const Table& runs = *find_table(estimate, "runs");
  ASSERT_EQ(runs.columns.back().name, "file");
  EXPECT_EQ(std::get<std::string>(runs.rows[0].back()), "monday.csv");
  EXPECT_EQ(std::get<std::string>(runs.rows[1].back()), "tuesday.csv");
}

// Two power-ups whose means agree by chance: what each of them does not know of its mean remains.
TEST(StaticBias, TheBiasOfSeveralIsKnownNoBetterThanTheirNoise) {
  const NoiseModel noise{.angle_random_walk = 1.0};
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Evidence evidence = at_rest(noise, 0.0, 2000, 2 * seed);
    evidence.recordings.push_back(at_rest(noise, 0.0, 2000, 2 * seed + 1).recordings[0]);
    const auto estimate = find_method("static_bias").identify(evidence, {});
    EXPECT_GT(standard_uncertainty(estimate, 0), 0.9 / std::sqrt(2.0 * 2000.0)) << seed;
  }
}

TEST(StaticBias, SaysWhichPowerUpIsUnlikeTheOthersAndWhereItSteps) {
  const NoiseModel noise{.angle_random_walk = 1.0};
  Evidence evidence = at_rest(noise, 0.0, 2000, 1);
  for (std::uint64_t seed = 2; seed <= 8; ++seed)
    evidence.recordings.push_back(at_rest(noise, seed == 5 ? 1.0 : 0.0, 2000, seed).recordings[0]);
  const auto outlying = find_method("static_bias").identify(evidence, {});
  EXPECT_TRUE(has_finding(outlying.findings, "power_up_differs"));
  EXPECT_FALSE(has_finding(outlying.findings, "bias_jumps"));
  auto& values = evidence.recordings[2].channels[0].values;
  for (std::size_t i = 900; i < values.size(); ++i) values[i] += 3.0;
  EXPECT_TRUE(has_finding(find_method("static_bias").identify(evidence, {}).findings, "bias_jumps"));
}

// A room that does the same after each power-up, a warm-up, a step: none is noise, since that of one power-up has nothing in
// common with that of another.
TEST(StaticBias, SaysWhatAllPowerUpsHaveInCommon) {
  const NoiseModel noise{.angle_random_walk = 1.0, .bias_instability = 0.05, .rate_random_walk = 0.003};
  const auto codes_with = [&](const std::function<double(double)>& course, std::uint64_t first) {
    Evidence evidence = at_rest(noise, 0.0, 2000, first);
    for (std::uint64_t seed = 1; seed < 6; ++seed)
      evidence.recordings.push_back(at_rest(noise, 0.1 * static_cast<double>(seed), 2000, first + seed).recordings[0]);
    for (Recording& recording : evidence.recordings)
      for (std::size_t i = 0; i < 2000; ++i) recording.channels[0].values[i] += course(static_cast<double>(i) / 2000.0);
    return has_finding(find_method("static_bias").identify(evidence, {}).findings, "power_ups_share_course");
  };
  for (std::uint64_t first = 100; first < 800; first += 100) {
    EXPECT_FALSE(codes_with([](double) { return 0.0; }, first)) << first;
    EXPECT_TRUE(codes_with([](double t) { return 0.4 * std::sin(30.0 * t); }, first)) << first;
    EXPECT_TRUE(codes_with([](double t) { return t < 0.43 ? 0.0 : 0.5; }, first)) << first;
    EXPECT_TRUE(codes_with([](double t) { return std::exp(-10.0 * t); }, first)) << first;
  }
}

// Rounded to steps, or cut off to the step below: the noise does not even it out.
TEST(StaticBias, StepsGreaterThanTheNoiseAreInTheUncertainty) {
  for (const auto rounded : {+[](double v) { return std::round(v); }, +[](double v) { return std::floor(v); }}) {
    double squares = 0.0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const double bias = 10.0 + static_cast<double>(seed) / 40.0;
      Evidence one = at_rest({.angle_random_walk = 0.3}, bias, 4000, 5100 + seed);
      for (double& sample : one.recordings[0].channels[0].values) sample = rounded(sample);
      const Estimate estimate = find_method("static_bias").identify(one, {});
      squares += std::pow((value(estimate, "bias") - bias) / standard_uncertainty(estimate, 0), 2);
    }
    EXPECT_LT(std::sqrt(squares / 40.0), 2.0);
    EXPECT_GT(std::sqrt(squares / 40.0), 0.05);
  }
}

TEST(StaticBias, AsksWhichOfSeveralChannelsIsMeant) {
  auto evidence = at_rest({.angle_random_walk = 1.0}, 0.0, 2000, 1);
  evidence.recordings[0].channels.push_back(evidence.recordings[0].channels[0]);
  evidence.recordings[0].channels[1].name = "other";
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"gyro", "other"}, .pattern = "several channels"},
                      [&] { find_method("static_bias").identify(evidence, {}); }));
  evidence.plan.channels["signal"] = {{"other", {}}};
  EXPECT_EQ(find_method("static_bias").identify(evidence, {}).parameters[0].name, "bias");
}

}  // namespace
}  // namespace tumble::static_bias
