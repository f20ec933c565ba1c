#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "tumble/math/random.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble::gyro_scale_factor_test {
namespace {

const Method& method() { return find_method("gyro_scale_factor"); }

/// A gyro on an ideal vertical table at the equator, its input axis along the table's: no Earth rate along it.
struct Bench {
  std::vector<double> rates{-100, -50, -20, -5, 0, 5, 20, 50, 100};  ///< [deg/s]
  double (*output)(double rate) = [](double rate) { return 2.0 * (rate + si(3.0, "deg/h")); };
  double noise = 0.0;
  int runs = 1;
  std::string unit = "V";
  double latitude = 0.0;

  Evidence evidence(std::uint64_t seed = 1) const {
    Evidence e;
    e.plan.method = "gyro_scale_factor";
    e.plan.settings = defaults(method().options());
    e.plan.rig_kind = "rate_table";
    e.plan.rig = defaults(find_rig("rate_table").options());
    e.plan.rig.set_flag("ideal", true);
    e.plan.site = Site{.latitude = latitude};
    Channel gyro{"gyro", kind_of(Unit::parse(unit)), Unit::parse(unit), {0.0, 10.0, nullptr}, {}};
    Recording recording;
    const double vertical = 7.292115e-5 * std::sin(latitude);
    double begin = 0.0;
    for (int run = 1; run <= runs; ++run)
      for (std::size_t k = 0; k < rates.size(); ++k, begin += 30.0) {
        Segment segment{fmt::format("{}: {} deg/s", k + 1, rates[k]), 30.0, run, {}};
        segment.axes["table"] = {.kind = Motion::Kind::rate, .value = si(rates[k], "deg/s")};
        if (k == 0) segment.axes["mount_pitch"] = {.kind = Motion::Kind::hold, .value = si(-90.0, "deg")};
        e.plan.schedule.push_back(segment);
        recording.marks.push_back({segment.label, begin, run});
        for (int i = 0; i < 300; ++i) gyro.values.push_back(output(si(rates[k], "deg/s") + vertical));
      }
    const RandomStream random(seed);
    for (std::size_t i = 0; i < gyro.values.size(); ++i) gyro.values[i] += noise * random.normal(i);
    recording.channels.push_back(std::move(gyro));
    e.recordings.push_back(std::move(recording));
    return e;
  }
};

double sd_of(const Estimate& estimate, const std::string& name) {
  const Parameter* p = find_parameter(estimate, name);
  return p == nullptr ? std::nan("")
                      : standard_uncertainty(estimate, static_cast<std::size_t>(p - estimate.parameters.data()));
}

TEST(GyroScaleFactor, NoiseFreeTruthToRounding) {
  Bench bench;
  bench.latitude = 0.6;  // the Earth's rate along the axis is not part of the bias
  bench.output = [](double w) { return 2.0 * (w + si(3.0, "deg/h") + 0.5 * 80e-6 * std::abs(w)); };
  const Estimate estimate = method().identify(bench.evidence(), {});
  EXPECT_NEAR(value(estimate, "scale_factor"), 2.0, 1e-12);
  // Rounding of outputs up to 3.5 V is 4e-16; over 2: 1e-10 of the bias of 1.5e-5 rad/s.
  EXPECT_NEAR(value(estimate, "bias") / si(3.0, "deg/h"), 1.0, 1e-8);
  EXPECT_NEAR(value(estimate, "scale_factor_asymmetry"), 80e-6, 1e-11);
  EXPECT_NEAR(value(estimate, "third_order_coefficient"), 0.0, 1e-11);
  EXPECT_EQ(find_parameter(estimate, "scale_factor")->unit.text(), "V/(deg/s)");
}

TEST(GyroScaleFactor, CountsAndRatesHaveTheirUnits) {
  Bench bench;
  bench.unit = "pulse";
  bench.output = [](double w) { return 0.1 * 0.5 / si(1.0, "arcsec") * w; };  // 0.5 pulse/arcsec, 0.1 s
  const Estimate counts = method().identify(bench.evidence(), {});
  EXPECT_EQ(find_parameter(counts, "scale_factor")->unit.text(), "pulse/arcsec");
  EXPECT_NEAR(value(counts, "scale_factor") * si(1.0, "arcsec"), 0.5, 1e-12);
  bench.unit = "deg/s";
  bench.output = [](double w) { return 1.0002 * w; };
  EXPECT_NEAR(value(method().identify(bench.evidence(), {}), "scale_factor"), 1.0002, 1e-12);
}

/// Rates up and down again, with noise of 1e-5 of full range.
Bench up_and_down() {
  Bench bench;
  bench.rates = {-100, -50, -20, -5, 0, 5, 20, 50, 100, 100, 50, 20, 5, 0, -5, -20, -50, -100};
  bench.noise = 3.5e-5;
  return bench;
}

/// Adds to each sample what `change` gives [V] for its time [s], its value [V] and the time [s] in its segment of 30 s.
template <class Change>
Findings findings_with(const Change& change, std::uint64_t seed) {
  Evidence evidence = up_and_down().evidence(seed);
  auto& values = evidence.recordings[0].channels[0].values;
  const std::vector<double> sound = values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t in_segment = i % 300;
    const double step = i < 300 ? 0.0 : sound[i] - sound[i - in_segment - 1];
    values[i] +=
        change(0.1 * static_cast<double>(i), sound[i], step * std::exp(-0.01 * static_cast<double>(in_segment)));
  }
  return method().identify(evidence, {}).findings;
}

// A tenth of a per cent of each step decays with 10 s: 3.5 mV after the greatest step but one, where the mean of a
// third of a segment is known to 3.5 uV.
TEST(GyroScaleFactor, AnOvershootOfTheTableIsSaid) {
  const auto overshoot = [](double, double, double decaying) { return 1e-3 * decaying; };
  const auto none = [](double, double, double) { return 0.0; };
  for (std::uint64_t seed = 0; seed < 5; ++seed)
    EXPECT_TRUE(has_finding(findings_with(overshoot, seed), "segments_settle"));
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Findings sound = findings_with(none, seed);
    for (const char* code :
         {"segments_settle", "segments_end_in_next", "segments_begin_in_last", "bias_drifts", "scale_factor_drifts"})
      EXPECT_FALSE(has_finding(sound, code)) << code << seed;
  }
}

// 540 s with 100 ppm of the scale factor, or with 2e-4 V of the bias: a mean of 28 s is known to 2 uV, 0.6 ppm of
// range.
TEST(GyroScaleFactor, ADriftOverTheTestIsSaidAsWhatItIs) {
  const auto of_scale = [](double time, double value, double) { return 1e-4 * time / 540.0 * value; };
  const auto of_bias = [](double time, double, double) { return 2e-4 * time / 540.0; };
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Findings scale = findings_with(of_scale, seed), bias = findings_with(of_bias, seed);
    EXPECT_TRUE(has_finding(scale, "scale_factor_drifts")) << seed;
    EXPECT_FALSE(has_finding(scale, "bias_drifts")) << seed;
    EXPECT_TRUE(has_finding(bias, "bias_drifts")) << seed;
    EXPECT_FALSE(has_finding(bias, "scale_factor_drifts")) << seed;
  }
}

TEST(GyroScaleFactor, NonlinearityIsSignificantOrLimited) {
  Bench bench;
  bench.noise = 2e-3;  // of a mean of 28 s: 1.2e-4 V, 34 ppm of 3.5 V
  EXPECT_TRUE(has_finding(method().identify(bench.evidence(), {}).findings, "not_significant",
                          {{"parameter", "nonlinearity"}}));
  bench.noise = 2e-5;
  bench.output = [](double w) { return 2.0 * w * (1.0 + 2e-4 * w * w); };
  const Estimate estimate = method().identify(bench.evidence(), {});
  // Departure of w^3 from its line over these rates, at 50 deg/s: -0.5 K 2e-4 W^3 ... as by hand below.
  double fourth = 0.0, second = 0.0, most = 0.0;
  for (const double r : bench.rates) second += r * r, fourth += r * r * r * r;
  for (const double r : bench.rates)
    most = std::max(
        most, std::abs(std::pow(si(r, "deg/s"), 3) - fourth / second * std::pow(si(1.0, "deg/s"), 2) * si(r, "deg/s")));
  const double expected = 2e-4 * most / si(100.0, "deg/s");
  EXPECT_NEAR(value(estimate, "nonlinearity") / expected, 1.0, 0.02);
  EXPECT_LT(value(estimate, "nonlinearity_rms"), value(estimate, "nonlinearity"));
}

TEST(GyroScaleFactor, HysteresisUpAndDown) {
  Bench bench;
  bench.rates = {-100, -50, -10, 0, 10, 50, 100, 50, 10, 0, -10, -50, -100};
  bench.noise = 1e-4;
  const Estimate none = method().identify(bench.evidence(), {});
  EXPECT_TRUE(has_finding(none.findings, "not_significant", {{"parameter", "hysteresis"}}));
  // On the way down everything stands 2e-3 V higher: 570 ppm of 3.49 V. Four cycles distinguish it from the scatter.
  const auto once = bench.rates;
  for (int cycle = 0; cycle < 3; ++cycle) bench.rates.insert(bench.rates.end(), once.begin() + 1, once.end());
  Evidence evidence = bench.evidence();
  auto& values = evidence.recordings[0].channels[0].values;
  for (std::size_t k = 1; k < bench.rates.size(); ++k)
    if (bench.rates[k] < bench.rates[k - 1])
      for (std::size_t i = 300 * k; i < 300 * (k + 1); ++i) values[i] += 2e-3;
  const Estimate some = method().identify(evidence, {});
  EXPECT_NEAR(value(some, "hysteresis") / (2e-3 / (2.0 * si(100.0, "deg/s"))), 1.0,
              0.02);  // 1e-4/sqrt(280) V against 2e-3 V
  EXPECT_FALSE(has_finding(some.findings, "not_significant", {{"parameter", "hysteresis"}}));
}

TEST(GyroScaleFactor, ThresholdBetweenTheRatesTried) {
  Bench bench;
  bench.rates = {-100, -50, -0.5, -0.2, -0.1, -0.05, -0.02, 0, 0.02, 0.05, 0.1, 0.2, 0.5, 50, 100};
  bench.output = [](double w) { return std::abs(w) < si(0.07, "deg/s") ? 0.0 : 2.0 * w; };
  bench.noise = 1e-6;  // without it the values are those of a converter with steps of 0.02 deg/s
  const Estimate estimate = method().identify(bench.evidence(), {});
  EXPECT_NEAR(value(estimate, "threshold"), si(0.075, "deg/s"), si(0.001, "deg/s"));
  EXPECT_NEAR(sd_of(estimate, "threshold"), si(0.025, "deg/s") / std::sqrt(3.0), si(0.001, "deg/s"));
}

TEST(GyroScaleFactor, TurnOnOverRuns) {
  Bench bench;
  bench.runs = 6;
  bench.noise = 1e-5;
  Evidence evidence = bench.evidence();
  const double offsets[]{1e-4, -2e-4, 1.5e-4, 0.0, -1e-4, 0.5e-4};
  for (std::size_t i = 0; i < evidence.recordings[0].channels[0].values.size(); ++i)
    evidence.recordings[0].channels[0].values[i] += offsets[i / 2700];
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_NEAR(value(estimate, "turn_on_repeatability") / (1.2910e-4 / 2.0), 1.0, 0.05);  // sd of the offsets, over K
  EXPECT_TRUE(has_finding(estimate.findings, "not_significant", {{"parameter", "scale_factor_repeatability"}}));
}

TEST(GyroScaleFactor, RefusesOrNamesWhatOneSidedRatesDoNotShow) {
  Bench bench;
  bench.noise = 1e-4;
  bench.rates = {20, 20, 20};
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "one rate only"}, refusal(method(), bench.evidence())));
  bench.rates = {5, 20, 50, 100};
  const Estimate one_sign = method().identify(bench.evidence(), {});
  EXPECT_EQ(find_parameter(one_sign, "scale_factor_asymmetry"), nullptr);
  EXPECT_TRUE(has_finding(one_sign.findings, "not_distinguished", {{"term", "scale_factor_asymmetry"}}));
  bench.rates = {-100, 0, 100};
  bench.output = [](double) { return 1.0; };
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "does not follow the rate"},
                      refusal(method(), bench.evidence())));
}

TEST(GyroScaleFactor, ClippedSegmentsAndJumpsAreNotUsed) {
  Bench bench;
  bench.noise = 1e-3;
  Evidence evidence = bench.evidence();
  auto& values = evidence.recordings[0].channels[0].values;
  for (double& v : values) v = std::min(v, 3.0);  // 100 deg/s is 3.49 V
  values[1000] += 65536.0;
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_TRUE(has_finding(estimate.findings, "segment_clipped"));
  EXPECT_TRUE(has_finding(estimate.findings, "jumps"));
  EXPECT_NEAR(value(estimate, "scale_factor"), 2.0, 5.0 * sd_of(estimate, "scale_factor"));
}

// The table stays at -20 deg/s where -5 was due: 0.026 V beside, which a rate above a tenth of the greatest would show.
TEST(GyroScaleFactor, ASegmentWithTheRateOfAnotherIsSaid) {
  Bench bench;
  bench.noise = 1e-3;
  Evidence evidence = bench.evidence();
  EXPECT_FALSE(has_finding(method().identify(evidence, {}).findings, "segment_reads_as_another"));
  auto& values = evidence.recordings[0].channels[0].values;
  std::copy(values.begin() + 600, values.begin() + 900, values.begin() + 900);
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_TRUE(has_finding(estimate.findings, "segment_reads_as_another",
                          {{"segment", "4: -5 deg/s"}, {"other", "3: -20 deg/s"}}));
}

// Zeros of a driver at 20 deg/s and more are no samples; at rest zero is one of the values.
TEST(GyroScaleFactor, ZerosOfADriverAreNotUsed) {
  Bench bench;
  bench.noise = 1e-3;
  Evidence evidence = bench.evidence();
  auto& values = evidence.recordings[0].channels[0].values;
  for (const std::size_t i : {100, 101, 450, 2200, 1350}) values[i] = 0.0;
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_TRUE(has_finding(estimate.findings, "zeros_not_used"));
  EXPECT_NEAR(value(estimate, "scale_factor"), 2.0, 5.0 * sd_of(estimate, "scale_factor"));
  EXPECT_LT(sd_of(estimate, "scale_factor"), 1e-3);
}

// Steps of 10 and of 3 noise sd: no segment is clipped, and no step is a zero of a driver.
TEST(GyroScaleFactor, ACoarseOutputIsNotClippedAndItsErrorIsIncluded) {
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Bench bench;
    bench.noise = 1e-3;
    bench.rates = {-100, -51, -20.3, -5.1, 0, 5.7, 20.9, 50.2, 100};
    Evidence evidence = bench.evidence(seed);
    const double step = seed % 2 == 0 ? 1e-2 : 3e-3, offset = 1e-4 * static_cast<double>(seed);
    for (double& v : evidence.recordings[0].channels[0].values) v = step * std::round((v + offset) / step);
    const Estimate estimate = method().identify(evidence, {});
    EXPECT_FALSE(has_finding(estimate.findings, "segment_clipped")) << seed;
    EXPECT_FALSE(has_finding(estimate.findings, "zeros_not_used")) << seed;
    squares += std::pow((value(estimate, "scale_factor") - 2.0) / sd_of(estimate, "scale_factor"), 2);
  }
  EXPECT_LT(std::sqrt(squares / 20.0), 1.7);  // chi-square of 20, p = 1e-5
}

// The largest tenth is lost: 100 deg/s whole, and of 50 deg/s what noise carries upward.
// Steps of ten times the noise, at rates that are multiples of one another: the errors of rounding go together, and three sd as
// large as independent ones were in the bias.
TEST(GyroScaleFactor, RoundingAtRatesThatAreMultiplesIsInTheIntervals) {
  constexpr std::size_t tests = 40;
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= tests; ++seed) {
    Trial trial = trial_of(method(), seed);
    const double step = 4e-4 * (1.0 + 0.1 * RandomStream(seed).uniform(0));
    for (Channel& channel : trial.evidence.recordings[0].channels)
      if (channel.name == "gyro")
        for (double& v : channel.values) v = step * std::round(v / step);
    const Estimate estimate = method().identify(trial.evidence, {});
    const double bias = std::ranges::find(trial.truth, "bias", &std::pair<std::string, double>::first)->second;
    squares += std::pow((value(estimate, "bias") - bias) / sd_of(estimate, "bias"), 2) / tests;
  }
  EXPECT_LT(std::sqrt(squares), 1.6);
  EXPECT_GT(std::sqrt(squares), 0.5);
}

TEST(GyroScaleFactor, ValuesThatDecidedAboutTheirLossAreSaid) {
  Bench bench;
  bench.noise = 1e-3;
  Evidence evidence = bench.evidence();
  auto& values = evidence.recordings[0].channels[0].values;
  const double limit = 2.0 * si(50.0, "deg/s") + 2.0 * si(3.0, "deg/h") + 5e-4;
  for (double& v : values)
    if (v > limit) v = std::nan("");
  EXPECT_TRUE(has_finding(method().identify(evidence, {}).findings, "largest_values_missing"));
  Evidence interrupted = bench.evidence();  // by chance, at the greatest rate
  for (std::size_t i = 2400; i < 2700; i += 3) interrupted.recordings[0].channels[0].values[i] = std::nan("");
  EXPECT_FALSE(has_finding(method().identify(interrupted, {}).findings, "largest_values_missing"));
}

TEST(GyroScaleFactor, ATableThatDidNotReachItsRate) {
  Bench bench;
  bench.noise = 1e-3;
  Evidence evidence = bench.evidence();
  auto& values = evidence.recordings[0].channels[0].values;
  for (std::size_t i = 2100; i < 2400; ++i) values[i] *= 0.8;  // 50 deg/s
  EXPECT_TRUE(has_finding(method().identify(evidence, {}).findings, "unexpected_output"));
}

TEST(GyroScaleFactor, PredictsWhatItThenFinds) {
  const Trial trial = trial_of(method(), 3);
  const Estimate predicted = method().predict(trial.evidence.plan), found = method().identify(trial.evidence, {});
  // Relative: the prediction takes the output as a rate. The noise found scatters by about 1/sqrt(2 10) about the true.
  EXPECT_NEAR(sd_of(predicted, "scale_factor") / (sd_of(found, "scale_factor") / value(found, "scale_factor")), 1.0,
              0.7);
  EXPECT_NEAR(sd_of(predicted, "bias") / sd_of(found, "bias"), 1.0, 0.7);
}

// A plan whose gyro counts: the scale factor is that of its fringes, and as well known as that of the rate.
TEST(GyroScaleFactor, PredictsCountsInPulses) {
  Plan plan = trial_of(method(), 3).evidence.plan;
  const Estimate rate = method().predict(plan);
  plan.truth.set_word("output", "count");
  plan.truth.set_number("scale_factor", si(0.4423, "pulse/arcsec"), Unit::parse("pulse/arcsec"));
  const Estimate counts = method().predict(plan);
  EXPECT_NEAR(value(counts, "scale_factor") / si(0.4423, "pulse/arcsec"), value(rate, "scale_factor"), 1e-9);
  EXPECT_NEAR(sd_of(counts, "scale_factor") / value(counts, "scale_factor"),
              sd_of(rate, "scale_factor") / value(rate, "scale_factor"), 1e-9);
  EXPECT_NEAR(sd_of(counts, "bias") / sd_of(rate, "bias"), 1.0, 1e-6);
}

// Counts are pulses in a sample: recordings at 10 Hz and 20 Hz hold different counts of one rate.
TEST(GyroScaleFactor, EveryRecordingHasItsOwnRate) {
  Bench bench;
  bench.unit = "pulse";
  bench.output = [](double w) { return 0.1 * 0.5 / si(1.0, "arcsec") * w; };  // 0.5 pulse/arcsec, 0.1 s
  Evidence evidence = bench.evidence();
  Recording quick = evidence.recordings[0];
  Channel& gyro = quick.channels[0];
  gyro.timeline.rate = 20.0;
  std::vector<double> values;
  for (const double v : gyro.values) values.insert(values.end(), {0.5 * v, 0.5 * v});
  gyro.values = values;
  evidence.recordings.push_back(quick);
  EXPECT_NEAR(value(method().identify(evidence, {}), "scale_factor") * si(1.0, "arcsec"), 0.5, 1e-12);
  std::swap(evidence.recordings[0], evidence.recordings[1]);
  EXPECT_NEAR(value(method().identify(evidence, {}), "scale_factor") * si(1.0, "arcsec"), 0.5, 1e-12);
}

// The plan states the rates once; the recording holds them twice.
TEST(GyroScaleFactor, CountsOfARepeatedRunAreNotClipped) {
  Bench bench;
  bench.unit = "pulse";
  bench.output = [](double w) { return std::round(0.1 * 0.5 / si(1.0, "arcsec") * w); };
  Evidence evidence = bench.evidence();
  Recording& recording = evidence.recordings[0];
  Channel& gyro = recording.channels[0];
  const auto once = gyro.values;
  gyro.values.insert(gyro.values.end(), once.begin(), once.end());
  const auto marks = recording.marks;
  for (Mark mark : marks) {
    mark.begin += 30.0 * static_cast<double>(marks.size());
    recording.marks.push_back(mark);
  }
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_FALSE(has_finding(estimate.findings, "segment_clipped"));
  EXPECT_NEAR(value(estimate, "scale_factor") * si(1.0, "arcsec"), 0.5, 1e-4);  // half a count of 5000 at 100 deg/s
}

// Counts are pulses in a sample: lost samples must not change what one pulse is worth.
TEST(GyroScaleFactor, LostSamplesDoNotChangeIt) {
  const Method& method = find_method("gyro_scale_factor");
  Trial trial = trial_of(method, 1);
  const auto whole = method.identify(trial.evidence, {});
  for (Channel& channel : trial.evidence.recordings[0].channels) {
    std::vector<double> stamps, values;
    for (std::size_t i = 0; i < channel.values.size(); ++i) {
      if (i >= channel.values.size() / 3 && i < channel.values.size() / 3 + 40) continue;
      stamps.push_back(channel.time(i));
      values.push_back(channel.values[i]);
    }
    channel.values = std::move(values);
    channel.timeline = {0.0, 0.0, std::make_shared<const std::vector<double>>(std::move(stamps))};
  }
  const auto part = method.identify(trial.evidence, {});
  EXPECT_NEAR(part.parameters[0].value, whole.parameters[0].value, 4.0 * standard_uncertainty(part, 0));
}

}  // namespace
}  // namespace tumble::gyro_scale_factor_test
