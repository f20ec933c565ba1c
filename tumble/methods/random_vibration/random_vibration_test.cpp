#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <variant>

#include "tumble/math/random.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/random_vibration/measure.hpp"
#include "tumble/methods/random_vibration/spectrum.hpp"
#include "tumble/methods/random_vibration/statistics.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/models/model.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/error.hpp"

namespace tumble::random_vibration_test {
namespace {

using namespace random_vibration;

const SpectralDensity paper{{20.0, 2000.0}, {0.1, 0.1}};  // g^2/Hz

Trial trial(std::uint64_t seed) { return trial_of(find_method("random_vibration"), seed); }
Estimate identified(const Evidence& evidence) { return find_method("random_vibration").identify(evidence, {}); }

double sd(const Estimate& estimate, const std::string& name) {
  const Parameter* p = find_parameter(estimate, name);
  return p ? standard_uncertainty(estimate, static_cast<std::size_t>(p - estimate.parameters.data())) : std::nan("");
}

// The numbers that Lu Hanjie et al. imply, to the last digit printed: docs/equations (3.12), (3.13).
TEST(RandomVibration, NumbersOfThePaper) {
  EXPECT_NEAR(std::sqrt(variance(paper)), 14.0712, 1e-4);
  EXPECT_NEAR(variance(paper), 198.0, 1e-9);
  EXPECT_NEAR(std::sqrt(window_variance(paper, 0.005)), 2.8143, 1e-4);
  EXPECT_NEAR(window_variance(paper, 0.005), 0.1 * 79.2, 0.1 * 0.05);
  EXPECT_NEAR(10e-6 * variance(paper), 1.98e-3, 1e-12);
  EXPECT_NEAR(20e-6 * variance(paper), 3.96e-3, 1e-12);
  // Standard deviation of the plain mean over 100 s from the motion itself: 1.6e-4 g.
  const double g = 9.80665, time = 100.0;
  const SpectralDensity si_paper{paper.frequency, {0.1 * g * g, 0.1 * g * g}};
  const double of_mean = std::sqrt(2.0 * velocity_variance(si_paper)) / time / g;
  EXPECT_NEAR(of_mean, std::sqrt(0.1 / (2.0 * std::numbers::pi * std::numbers::pi * time * time * 20.0)),
              0.01 * of_mean);
  EXPECT_NEAR(of_mean, 1.6e-4, 0.05e-4);
  EXPECT_NEAR(density_of_square(paper), 19.8, 1e-9);
}

// K_2 = 20 ug/g^2, K_3 = 0.5 ug/g^3, a_0 = 1 g: 4.257e-3 g, by a million numbers of 14.071 g.
TEST(RandomVibration, RectificationBySimulation) {
  const double rms = std::sqrt(variance(paper));
  std::vector<double> a(1'000'000);
  RandomStream(12).normal(0, a);
  double sum = 0.0, squares = 0.0;
  for (const double v : a) {
    const double x = 1.0 + rms * v, y = 20e-6 * (x * x - 1.0) + 0.5e-6 * (x * x * x - 1.0);
    // The part that is odd in v has no mean: it is subtracted, else it is nearly all of the scatter.
    const double even = y - (2.0 * 20e-6 + 3.0 * 0.5e-6) * rms * v - 0.5e-6 * std::pow(rms * v, 3);
    sum += even;
    squares += even * even;
  }
  const double n = 1e6, mean = sum / n, of_mean = std::sqrt((squares / n - mean * mean) / n);
  EXPECT_NEAR(mean, 4.257e-3, 4.0 * of_mean + 5e-7);
}

// docs/equations (3.14): a constant of p pulses a window gives variance p(1 - p) and lag-1 correlation -min/max of p
// and 1 - p.
TEST(RandomVibration, RoundingOfAConstant) {
  const Model& model = find_model("pendulous_accelerometer");
  Settings truth = defaults(truth_options(model));
  truth.set_word("output", "count");
  truth.set_number("pulse_scale_factor", 1.0, Unit());
  for (const double p : {0.0, 0.1, 0.25, 0.5, 0.7}) {
    const Response counter = model.record(truth, 0, 1.0, RandomStream(3)).response;
    // A little off p, so that the fraction runs through all phases: 1e-7 of a window.
    std::vector<double> n(100'000, 7.0 + p + 1e-7);
    counter(n);
    double mean = 0.0, squares = 0.0, products = 0.0;
    for (const double v : n) mean += v / 1e5;
    for (std::size_t j = 0; j + 1 < n.size(); ++j) {
      squares += (n[j] - mean) * (n[j] - mean) / 1e5;
      products += (n[j] - mean) * (n[j + 1] - mean) / 1e5;
    }
    EXPECT_NEAR(squares, p * (1.0 - p), 1e-3) << p;
    if (p > 0.0) {
      EXPECT_NEAR(products / squares, -std::min(p, 1 - p) / std::max(p, 1 - p), 1e-2) << p;
    }
    EXPECT_NEAR(mean, 7.0 + p, 1.1e-5) << p;  // one pulse of the whole run at most
  }
}

// Each number counts as the middle of its step of 0.002: the mean and the sd are off by half a step at most.
TEST(RandomVibration, GreatestOfNormalNumbers) {
  EXPECT_NEAR(greatest_of(1.0).mean, 0.0, 1e-3);
  EXPECT_NEAR(greatest_of(2.0).mean, 1.0 / std::sqrt(std::numbers::pi), 1e-3);
  EXPECT_NEAR(greatest_of(2.0).sd, std::sqrt(1.0 - 1.0 / std::numbers::pi), 1e-3);
  EXPECT_NEAR(greatest_of(1000.0).mean, 3.2414, 1e-3 + 5e-5);  // tables of normal order statistics, their last digit
  EXPECT_NEAR(greatest_of(1000.0).sd, 0.3514, 1e-3 + 5e-5);
}

// Gaussian vibration of 14.07 g about +1 g, cut at 30 g: 4 sigma of a million.
TEST(RandomVibration, ClippingBySimulation) {
  const double rms = 14.0712, range = 30.0;
  std::vector<double> a(1'000'000);
  RandomStream(9).normal(0, a);
  double beyond = 0.0, shift = 0.0, squares = 0.0;
  for (const double v : a) {
    const double x = 1.0 + rms * v, lost = std::clamp(x, -range, range) - x;
    beyond += lost != 0.0;
    shift += lost;
    squares += lost * lost;
  }
  const Clipping clip = clipping(1.0, rms, range);
  EXPECT_NEAR(clip.share, beyond / 1e6, 4.0 * std::sqrt(clip.share / 1e6));
  EXPECT_NEAR(clip.shift, shift / 1e6, 4.0 * std::sqrt(squares) / 1e6);
  EXPECT_LT(clip.shift, -0.02);  // downwards: the offset brings the upper peaks nearer to the end
  EXPECT_EQ(clipping(0.0, rms, range).shift, 0.0);
}

// Both units feel the same: of the ratio of their means hardly more is left uncertain than the noise at rest makes.
TEST(RandomVibration, CommonVibrationCancelsInTheRatio) {
  const Trial t = trial(1);
  const Estimate e = identified(t.evidence);
  const double first = sd(e, "accelerometer.pulse_error_sd") / value(e, "accelerometer.pulse_error_sd");
  EXPECT_LT(sd(e, "accelerometer_over_Q1.sd_ratio"), 0.1 * first);
  EXPECT_NEAR(value(e, "accelerometer_over_Q1.sd_ratio"), 1.0, 1e-3);
  const auto ratio = value(e, "accelerometer_over_Q1.mean_ratio");
  EXPECT_LT(ratio, 0.6);
  EXPECT_NE(finding_of(e.findings, "spread_is_motion_beside_instants"), nullptr);
}

TEST(RandomVibration, UnitsAreGroupedIntoTypes) {
  std::vector<vibration::UnitUnderTest> units(3);
  units[0].name = "Q1", units[1].name = "Q2", units[2].name = "S1";
  const auto types = types_of("quartz: Q1 Q2; wire: S1", units);
  ASSERT_EQ(types.size(), 2u);
  EXPECT_EQ(types[0].units, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(types[1].name, "wire");
  EXPECT_EQ(types_of("", units).size(), 3u);
  const Refused refused = refusal_of([&] { types_of("quartz: Q1 Q3; wire: S1 Q1; ; odd; empty:", units); });
  EXPECT_EQ(refused.problems.size(), 5u);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"Q3"}, .pattern = "no unit"}, refused));
}

/// A unit whose only error is white noise of 3 mg a window, beside a reference over the windows. 0.5 mg noise.
Evidence with_reference(const char* how, int steps) {
  Evidence evidence = trial(1).evidence;
  Plan& plan = evidence.plan;
  plan.beside.clear();
  plan.settings.set_word("scale_factor", "2000 pulse/s/g");
  plan.settings.set_word("reference_is", std::string(how) == "mean" ? "window" : "instant");
  plan.rig.set_word("reference_output", how);
  plan.truth.set_word("output", "specific_force");
  plan.truth.set_integer("oversampling", steps);
  plan.truth.set_number("angle_random_walk", si(3.0, "mg") / std::sqrt(200.0), Unit());
  evidence.recordings = {simulate(plan, 3, {})};
  return evidence;
}

// The residual is the unit's own 3 mg and the reference's 1 mg, of 2.8 g: 1 % of it the rectified a^2 and what the
// steps of the simulation, 100 a window, do to 2 kHz.
TEST(RandomVibration, ReferenceOverTheWindowsShowsTheUnitsOwnError) {
  const Estimate e = identified(with_reference("mean", 200));
  EXPECT_GT(value(e, "pulse_error_sd"), si(2.5, "g"));
  EXPECT_NEAR(value(e, "pulse_error_sd_own"), si(std::hypot(3.0, 1.0), "mg"), si(0.6, "mg"));
  EXPECT_GT(value_of(e.findings, "motion_in_reference", "share"), 0.99);
}

// An instant tells the level, with all of the band, but not the mean over the window.
TEST(RandomVibration, ReferenceOfInstantsShowsTheLevel) {
  Evidence evidence = with_reference("instant", 25);
  EXPECT_EQ(find_parameter(identified(evidence), "pulse_error_sd_own"), nullptr);
  evidence.plan.settings.set_word("level_from", "reference");
  const Estimate e = identified(evidence);
  const double truth = trial(1).truth[3].second;
  EXPECT_NEAR(value(e, "vibration_rectification"), truth, 4.0 * sd(e, "vibration_rectification"));
  EXPECT_NE(finding_of(e.findings, "level_by_reference"), nullptr);
  evidence.plan.settings.set_number("level", si(15.5, "g"), Unit::parse("g"));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "level_from"},
                      refusal(find_method("random_vibration"), evidence)));
  evidence.plan.settings.set_word("level_from", "plan");
  const Findings findings = identified(evidence).findings;
  EXPECT_NEAR(value_of(findings, "level_differs_from_reference", "level"), si(15.5, "g"), 1e-9);
  EXPECT_EQ(text_of(findings, "level_differs_from_reference", "source"), "level_in_settings");
}

TEST(RandomVibration, ClippingIsReported) {
  Evidence evidence = trial(1).evidence;
  evidence.plan.settings.set_number("range", si(30.0, "g"), Unit::parse("g"));
  EXPECT_LT(value_of(identified(evidence).findings, "unit_clips", "shift"), 0.0);
  evidence.plan.settings.set_number("range", si(90.0, "g"), Unit::parse("g"));
  EXPECT_EQ(finding_of(identified(evidence).findings, "unit_clips"), nullptr);
}

TEST(RandomVibration, RestOnOneSideOnlyAndNone) {
  Evidence evidence = trial(1).evidence;
  evidence.plan.schedule[2].axes["shake"] = evidence.plan.schedule[1].axes["shake"];
  const Estimate e = identified(evidence);  // "after" is planned as a second vibration, and is none
  EXPECT_NE(finding_of(e.findings, "rest_only_before"), nullptr);
  EXPECT_NE(finding_of(e.findings, "vibration_absent"), nullptr);
  EXPECT_NE(find_parameter(e, "accelerometer.pulse_error_mean"), nullptr);
  evidence.plan.schedule[0].axes["shake"] = evidence.plan.schedule[1].axes["shake"];
  const auto words = refusal(find_method("random_vibration"), evidence);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "no segment at rest"}, words));
}

// Axis up and axis down: K_2 + 3 K_3 a_0 twice. The level is off by the same in both.
TEST(RandomVibration, TwoPositionsSplitTheOrders) {
  Evidence evidence = trial(1).evidence;
  Plan& plan = evidence.plan;
  plan.beside.clear();
  plan.settings.set_word("scale_factor", "2000 pulse/s/g");
  plan.settings.set_number("cross_coupling", 0.0, Unit::parse("ug/g^2"));
  plan.truth.set_number("cross_coupling_ip", 0.0, Unit::parse("ug/g^2"));
  plan.truth.set_number("cross_coupling_io", 0.0, Unit::parse("ug/g^2"));
  const Schedule up = plan.schedule;
  for (Segment segment : up) {
    segment.label += " down";
    segment.run = 2;
    segment.axes["mount_pitch"] = {.value = std::numbers::pi};
    plan.schedule.push_back(segment);
  }
  evidence.recordings = {simulate(plan, 5, {})};
  const Estimate e = identified(evidence);
  EXPECT_NEAR(value(e, "second_order_coefficient"), si(20.0, "ug/g^2"), 4.0 * sd(e, "second_order_coefficient"));
  EXPECT_NEAR(value(e, "third_order_coefficient"), si(0.5, "ug/g^3"), 4.0 * sd(e, "third_order_coefficient"));
  EXPECT_LT(sd(e, "second_order_coefficient"), si(0.2, "ug/g^2"));
  EXPECT_LT(sd(e, "third_order_coefficient"), si(0.05, "ug/g^3"));
  const std::size_t n = e.parameters.size();
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0.0;
    for (const auto& line : e.budget) sum += line.variance(i);
    EXPECT_NEAR(sum / e.covariance(i, i), 1.0, 1e-9) << e.parameters[i].name;
  }
}

TEST(RandomVibration, KnocksAreReported) {
  Evidence evidence = trial(1).evidence;
  auto& values = evidence.recordings[0].channels[0].values;
  values[8000] += 400.0;
  values[9000] -= 400.0;
  const Estimate both = identified(evidence);
  const Finding* differ = finding_of(both.findings, "units_differ_in_windows");
  ASSERT_NE(differ, nullptr);
  EXPECT_GE(differ->occurrences.count, 2u);
  EXPECT_LE(differ->occurrences.count, 10u);  // with the two windows on either side, which the regression knows too
  // One unit alone has nothing to be compared with but the normal peaks.
  evidence.recordings[0].channels.erase(evidence.recordings[0].channels.begin() + 1);
  evidence.plan.settings.set_word("scale_factor", "2000 pulse/s/g");
  EXPECT_NE(finding_of(identified(evidence).findings, "peaks_too_high"), nullptr);
}

// Each unit lacks windows of its own, a tenth: only windows in common cancel the motion. 4 sigma for each of 8 seeds;
// the ratio of all windows was 1.2 % off, 0.07 % stated.
TEST(RandomVibration, RatiosAreOverWindowsInCommon) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Trial t = trial(seed);
    for (Channel& channel : t.evidence.recordings[0].channels) {
      const RandomStream random = RandomStream(seed).split(channel.name);
      for (std::size_t i = 0; i < channel.values.size(); ++i)
        if (channel.name != "reference" && random.uniform(i) < 0.1) channel.values[i] = std::nan("");
    }
    const Estimate e = identified(t.evidence);
    for (const auto& [name, truth] : t.truth)
      if (name.ends_with("sd_ratio") || name.ends_with("pulse_error_mean")) {
        EXPECT_NEAR(value(e, name), truth, 4.0 * sd(e, name)) << name << " " << seed;
      }
    EXPECT_LT(sd(e, "accelerometer_over_Q1.sd_ratio"), 2e-3);
  }
}

// 5 % of the scale factor of one unit: the rests show it, and so does the spread. What rests on it is named, pulses are
// not.
TEST(RandomVibration, RestsContradictTheScaleFactor) {
  Evidence evidence = trial(1).evidence;
  EXPECT_EQ(finding_of(identified(evidence).findings, "scale_factor_differs_at_rest"), nullptr);
  evidence.plan.settings.set_word("scale_factor", "accelerometer: 2000 pulse/s/g, Q1: 2375 pulse/s/g");
  const Findings findings = identified(evidence).findings;
  const Finding* finding = finding_of(findings, "scale_factor_differs_at_rest");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->severity, Finding::Severity::error);
  EXPECT_EQ(finding->where, "Q1");
  const auto list = std::ranges::find(finding->values, "parameters", &FindingValue::name);
  const auto& names = std::get<std::string>(list->value);
  EXPECT_NE(names.find("Q1.vibration_rectification"), std::string::npos);
  EXPECT_EQ(names.find("pulse_error"), std::string::npos);
  EXPECT_EQ(names.find("accelerometer.vibration_rectification"), std::string::npos);
}

// What each of two units shows is that of the other: its rests are as planned with the other's scale factor.
TEST(RandomVibration, UnitsThatAreExchangedAreNamed) {
  Evidence evidence = trial(1).evidence;
  EXPECT_EQ(finding_of(identified(evidence).findings, "units_exchanged"), nullptr);
  auto& channels = evidence.recordings[0].channels;
  const auto values_of = [&](const char* name) -> std::vector<double>& {
    return std::ranges::find(channels, name, &Channel::name)->values;
  };
  std::swap(values_of("accelerometer"), values_of("Q1.accelerometer"));
  EXPECT_NE(finding_of(identified(evidence).findings, "units_exchanged"), nullptr);
  // both off by 5 % in one direction are not exchanged
  Evidence wrong = trial(1).evidence;
  wrong.plan.settings.set_word("scale_factor", "accelerometer: 1900 pulse/s/g, Q1: 2375 pulse/s/g");
  EXPECT_EQ(finding_of(identified(wrong).findings, "units_exchanged"), nullptr);
}

// 3 pulses with the temperature of the room, at 10 pulses a window: the rest shows it.
TEST(RandomVibration, ARestThatWandersIsSaid) {
  Evidence evidence = trial(1).evidence;
  EXPECT_EQ(finding_of(identified(evidence).findings, "rest_wanders"), nullptr);
  auto& values = evidence.recordings[0].channels[0].values;
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = std::round(values[i] + 3.0 * std::sin(0.33 * static_cast<double>(i) / 200.0));
  EXPECT_NE(finding_of(identified(evidence).findings, "rest_wanders"), nullptr);
}

// At 3.3 sd some ten windows are cut off: fewer than a pile, but the other unit shows more in each of them.
TEST(RandomVibration, AUnitThatClipsBesideAnotherIsNamed) {
  Evidence evidence = trial(1).evidence;
  EXPECT_EQ(finding_of(identified(evidence).findings, "saturated_highest"), nullptr);
  auto& values = evidence.recordings[0].channels[0].values;
  for (double& v : values) v = std::clamp(v, -84.0, 104.0);
  const Findings findings = identified(evidence).findings;
  EXPECT_TRUE(finding_of(findings, "saturated_highest") != nullptr ||
              finding_of(findings, "saturated_lowest") != nullptr);
}

// Squares of 1e-160 g are no numbers: refused, not an answer of 0 +- 0 nor an internal error.
TEST(RandomVibration, ValuesOfNoAccelerometerAreRefused) {
  for (const double scale : {1e-200, 1e-160, 1e200}) {
    Evidence evidence = trial(1).evidence;
    for (Channel& channel : evidence.recordings[0].channels)
      for (double& v : channel.values) v *= scale;
    EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "which no accelerometer does"},
                        refusal(find_method("random_vibration"), evidence)))
        << scale;
  }
}

}  // namespace
}  // namespace tumble::random_vibration_test
