// The closed forms of (3.5) against the model that they invert, the polynomials of (3.6), and evidence that is wrong.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/accelerometer_four_position/estimator.hpp"
#include "tumble/methods/accelerometer_four_position/reduce.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::accelerometer_four_position_test {
namespace {

using namespace accelerometer_four_position;

constexpr double G = 9.797;
const Method& method() { return find_method("accelerometer_four_position"); }

/// E/K_m in the four positions of an accelerometer with these coefficients, p up in position 2.
FourOutputs outputs(double s, double K_0, double K_2, double K_3, double theta) {
  const double a[] = {G, 0.0, -G, 0.0}, p[] = {0.0, G, 0.0, -G};
  FourOutputs y{};
  for (int k = 0; k < 4; ++k) y[k] = s * (K_0 + a[k] + K_2 * a[k] * a[k] + K_3 * a[k] * a[k] * a[k] + theta * p[k]);
  return y;
}

// 1e-15 relative of quantities that are differences of outputs of size G: 1e-14 m/s^2, over G and G^2.
TEST(FourPositions, ClosedFormsReturnWhatTheyShould) {
  const double s = 1.0015, K_0 = 0.03, K_2 = 4e-6, K_3 = 3e-8, theta = 4e-4, third = 1.0 + K_3 * G * G;
  const auto y = outputs(s, K_0, K_2, K_3, theta);
  const auto two = from_two(y, G), four = from_four(y, G, 1.0);
  EXPECT_NEAR(two.value[scale_factor_error], 1.0 / (s * third) - 1.0, 4e-15);
  EXPECT_NEAR(two.value[bias], (K_0 + K_2 * G * G) / third, 4e-14);
  EXPECT_NEAR(four.value[scale_factor_error], 1.0 / (s * third) - 1.0, 4e-15);
  EXPECT_NEAR(four.value[bias], K_0 / third, 4e-14);
  EXPECT_NEAR(four.value[second_order], K_2 / third, 1e-15);
  EXPECT_NEAR(four.value[misalignment], theta / third, 4e-15);
  EXPECT_NEAR(from_four(y, G, -1.0).value[misalignment], -theta / third, 4e-15);
}

// Central differences at 1e-4 of G: error of the third derivative, (1e-4)^2 relative.
TEST(FourPositions, SlopesAreTheDerivatives) {
  const auto y = outputs(0.99, 0.05, 1e-5, 0.0, 1e-3);
  const double h = 1e-3;
  const FourResults at = from_four(y, G, 1.0);
  for (std::size_t k = 0; k < 4; ++k) {
    FourOutputs up = y, down = y;
    up[k] += h;
    down[k] -= h;
    const auto above = from_four(up, G, 1.0), below = from_four(down, G, 1.0);
    for (std::size_t q = 0; q < quantities; ++q)
      EXPECT_NEAR((above.value[q] - below.value[q]) / (2.0 * h), at.slope[q][k], 1e-8) << q << k;
  }
}

struct Stand {
  std::string label;
  double head;  ///< [deg]
};

const std::vector<Stand> figure_11{{"1", 90.0}, {"2", 0.0}, {"3", 270.0}, {"4", 180.0}};

/// One run on a head: these positions at each temperature.
Plan plan_of(const std::vector<Stand>& stands, const std::vector<double>& celsius, double rate = 1.0) {
  Plan plan = trial_plan(method().name, method().options(), "pendulous_accelerometer", "dividing_head", rate);
  plan.site->gravity = G;
  plan.settings.set_word("scale_factor", "2000 pulse/s/g");
  plan.truth.set_word("output", "count");
  set_truth(plan, "pulse_scale_factor", 2000.0, "pulse/s/g");
  set_truth(plan, "bias", 2.5, "mg");
  set_truth(plan, "angle_random_walk", 0.01, "(m/s)/sqrt(h)");
  set_truth(plan, "bias_temperature_coefficient", 20.0, "ug/K");
  const auto hold = [](double value) { return Motion{.kind = Motion::Kind::hold, .value = value}; };
  for (const double t : celsius) {
    if (celsius.size() > 1) plan.schedule.push_back({"soak", 4500.0, 1, {{"temperature", hold(t + 273.15)}}});
    for (const auto& stand : stands)
      plan.schedule.push_back(
          {fmt::format("{} at {}", stand.label, t), 60.0, 1, {{"head", hold(si(stand.head, "deg"))}}});
  }
  return plan;
}

Evidence simulated(const Plan& plan, std::uint64_t seed = 1) { return {plan, {simulate(plan, seed, {})}}; }

void without_errors(Plan& plan) {
  plan.rig.set_flag("ideal", true);
  set_truth(plan, "angle_random_walk", 0.0, "(m/s)/sqrt(h)");
  plan.truth.set_word("output", "current");
  set_truth(plan, "current_scale_factor", 1.2, "mA/g");
  plan.settings.set_word("scale_factor", "1.2 mA/g");
}

// Rounding of means of 60 outputs of size G, 1e-15 G, and of the powers of T: (40 K/40 K)^2 and 1e-13 in b_2.
TEST(FourPositions, GivesTheTruthBackToRoundingWithoutNoise) {
  Plan plan = plan_of(figure_11, {-20.0, 15.0, 60.0});
  without_errors(plan);
  set_truth(plan, "bias_temperature_square", 0.3, "ug/K^2");
  set_truth(plan, "second_order_coefficient", 30.0, "ug/g^2");
  set_truth(plan, "misalignment_o", 100.0, "arcsec");
  const auto estimate = method().identify(simulated(plan), {});
  // bias about 20 degC: 2.5 mg + 20 ug/K (T - 20) + 0.3 ug/K^2 (T - 20)^2
  EXPECT_NEAR(value(estimate, "b_0"), si(2500.0 - 400.0 + 120.0, "ug"), 1e-12);
  EXPECT_NEAR(value(estimate, "b_1"), si(20.0 - 12.0, "ug/K"), 1e-13);
  EXPECT_NEAR(value(estimate, "b_2"), si(0.3, "ug/K^2"), 1e-14);
  EXPECT_NEAR(value(estimate, "bias"), si(2.5, "mg"), 1e-12);
  for (const char* name : {"c_0", "c_1", "c_2", "scale_factor_error"}) EXPECT_NEAR(value(estimate, name), 0.0, 1e-13);
  EXPECT_NEAR(value(estimate, "second_order_coefficient"), si(30.0, "ug/g^2"), 1e-13);
  EXPECT_NEAR(value(estimate, "misalignment"), si(100.0, "arcsec"), 1e-12);
}

TEST(FourPositions, TheSourcesEstimatorTakesK2AsBias) {
  Plan plan = plan_of(figure_11, {20.0});
  without_errors(plan);
  set_truth(plan, "second_order_coefficient", 30.0, "ug/g^2");
  plan.settings.set_word("estimator", "up_and_down");
  const auto estimate = method().identify(simulated(plan), {});
  EXPECT_NEAR(value(estimate, "bias"), si(2.5, "mg") + si(30.0, "ug/g^2") * G * G, 1e-12);
  EXPECT_EQ(find_parameter(estimate, "second_order_coefficient"), nullptr);
  EXPECT_TRUE(has_finding(estimate.findings, "second_order_in_bias"));
}

// With the instrument turned on the head the output axis is up in position 2: theta_p, of the other sign.
TEST(FourPositions, TheOtherMountGivesTheOtherAngle) {
  Plan plan = plan_of(figure_11, {20.0});
  without_errors(plan);
  set_truth(plan, "misalignment_p", -70.0, "arcsec");
  for (auto& segment : plan.schedule)
    segment.axes["mount_roll"] = {.kind = Motion::Kind::hold, .value = si(-90.0, "deg")};
  const auto estimate = method().identify(simulated(plan), {});
  EXPECT_NEAR(value(estimate, "misalignment"), si(-70.0, "arcsec"), 1e-12);
  EXPECT_EQ(find_parameter(estimate, "misalignment")->symbol, "theta_p");
}

TEST(FourPositions, ASetThatLacksAPositionIsSkippedByName) {
  Plan plan = plan_of(figure_11, {0.0, 40.0});
  plan.schedule.back().axes["head"].value = 0.0;
  const auto findings = method().identify(simulated(plan), {}).findings;
  EXPECT_EQ(text_of(findings, "position_missing_other_twice", "missing"), "4");
  EXPECT_EQ(text_of(findings, "position_missing", "missing"), "1, 3, 4");
}

TEST(FourPositions, ACurrentWithoutAScaleFactorIsRefusedByTheNameOfItsChannel) {
  for (const auto& [output, unit] : {std::pair{"current", "mA"}, std::pair{"voltage", "V"}}) {
    Plan plan = plan_of(figure_11, {20.0});
    plan.truth.set_word("output", output);
    const std::string scale = std::string(unit) + "/g";
    set_truth(plan, (std::string(output) + "_scale_factor").c_str(), 1.2, scale.c_str());
    plan.settings.set_word("scale_factor", "");
    const auto message = refusal(method(), simulated(plan));
    EXPECT_NE(message.find("channel 'accelerometer' is in " + std::string(unit)), std::string::npos) << message;
    EXPECT_NE(message.find("[settings] scale_factor must say how many " + scale), std::string::npos) << message;
  }
}

TEST(FourPositions, APositionMissingOrUnderTwoLabelsIsNamed) {
  const auto missing = refusal(method(), simulated(plan_of({figure_11[0], figure_11[1], figure_11[2]}, {20.0})));
  EXPECT_NE(missing.find("position 4 (level, turned over against 2) missing"), std::string::npos) << missing;
  auto stands = figure_11;
  stands[3].head = 0.0;
  const auto twice = refusal(method(), simulated(plan_of(stands, {20.0})));
  EXPECT_NE(twice.find("segments '2 at 20' and '4 at 20' both hold position 2"), std::string::npos) << twice;
}

TEST(FourPositions, ExchangedPositionsTurnTheSignOfTheScaleFactor) {
  Evidence evidence = simulated(plan_of(figure_11, {20.0}));
  std::swap(evidence.plan.schedule[0].axes, evidence.plan.schedule[2].axes);
  const auto findings = method().identify(evidence, {}).findings;
  const Finding* finding = finding_of(findings, "scale_factor_negative_in_set");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->occurrences.count, 1u);
  EXPECT_TRUE(finding->occurrences.worst.label.starts_with("run 1: ")) << finding->occurrences.worst.label;
}

TEST(FourPositions, TwoPositionsUnderOneLabelShowAsAStep) {
  Evidence evidence = simulated(plan_of(figure_11, {20.0}));
  auto& counts = evidence.recordings[0].channels[0].values;
  for (std::size_t i = 165; i < 180; ++i) counts[i] = 3.0;
  const auto findings = method().identify(evidence, {}).findings;
  const Finding* finding = finding_of(findings, "step_in_segment");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->occurrences.count, 1u);
  EXPECT_EQ(finding->occurrences.worst.label, "'3 at 20' (run 1)");
}

TEST(FourPositions, ACounterThatRanOverIsRefused) {
  Plan plan = plan_of(figure_11, {20.0});
  set_truth(plan, "pulse_scale_factor", 50000.0, "pulse/s/g");
  plan.settings.set_word("scale_factor", "50000 pulse/s/g");
  Evidence evidence = simulated(plan);
  for (double& n : evidence.recordings[0].channels[0].values)
    n = n > 32767.0 ? n - 65536.0 : n < -32768.0 ? n + 65536.0 : n;
  const auto message = refusal(method(), evidence);
  EXPECT_NE(message.find("differ by 2^16"), std::string::npos) << message;
  EXPECT_NE(message.find("'1 at 20'"), std::string::npos) << message;
  EXPECT_NE(message.find("'3 at 20'"), std::string::npos) << message;
}

// A register of 16 bits ends at 32767 pulses: 32900 G are just past it, so that the overflow nearly turns their sign.
TEST(FourPositions, ACounterJustPastItsEndIsRefusedToo) {
  Plan plan = plan_of(figure_11, {20.0});
  set_truth(plan, "pulse_scale_factor", 32900.0, "pulse/s/g");
  plan.settings.set_word("scale_factor", "32900 pulse/s/g");
  Evidence evidence = simulated(plan);
  for (double& n : evidence.recordings[0].channels[0].values)
    n = n > 32767.0 ? n - 65536.0 : n < -32768.0 ? n + 65536.0 : n;
  const auto message = refusal(method(), evidence);
  EXPECT_NE(message.find("differ by 2^16"), std::string::npos) << message;
}

// cos of 1 deg lacks 150 ppm: more than the scale factor is known by.
TEST(FourPositions, AHeadOneDegreeOffIsAnError) {
  Plan real = plan_of(figure_11, {0.0, 20.0, 40.0});
  const Plan planned = real;
  for (auto& segment : real.schedule)
    if (segment.axes.contains("head")) segment.axes["head"].value += si(1.0, "deg");
  const auto findings = method().identify({planned, {simulate(real, 1, {})}}, {}).findings;
  const Finding* finding = finding_of(findings, "misalignment_changes_scale_factor");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->severity, Finding::Severity::error);
}

// 2000 G are 1996 pulses a window; the amplifier ends at 1990. Sound tests of the same unit hold no such finding.
TEST(FourPositions, CountsAtALimitAreAnError) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Plan plan = plan_of(figure_11, {-20.0, 20.0, 60.0});
    Evidence evidence{plan, {simulate(plan, seed, {})}};
    EXPECT_FALSE(has_finding(method().identify(evidence, {}).findings, "one_value_in_segment")) << seed;
    for (double& n : evidence.recordings[0].channels[0].values) n = std::clamp(n, -1990.0, 1990.0);
    const auto findings = method().identify(evidence, {}).findings;
    const Finding* finding = finding_of(findings, "one_value_in_segment");
    ASSERT_NE(finding, nullptr) << seed;
    EXPECT_EQ(finding->severity, Finding::Severity::error);
    EXPECT_EQ(finding->occurrences.count, 6u);
  }
}

// A level position 1 deg off gives 17 mg, so that the angle of its set is off by half a degree.
TEST(FourPositions, OnePositionOneDegreeOffShowsAsASetThatDisagrees) {
  Plan real = plan_of(figure_11, {-20.0, 0.0, 20.0, 40.0, 60.0});
  const Plan planned = real;
  for (auto& segment : real.schedule)
    if (segment.label == "2 at 20") segment.axes["head"].value += si(1.0, "deg");
  const auto findings = method().identify({planned, {simulate(real, 1, {})}}, {}).findings;
  const Finding* finding = finding_of(findings, "set_disagrees");
  ASSERT_NE(finding, nullptr);
  EXPECT_NE(finding->message.find("20.0 degC"), std::string::npos) << finding->message;
}

// The soak states the mount as well, so that it looks like a position; it is none, and the sets are whole.
TEST(FourPositions, ASoakThatStatesTheMountIsNoPosition) {
  Plan plan = plan_of(figure_11, {-20.0, 20.0, 60.0});
  for (auto& segment : plan.schedule)
    if (segment.label == "soak") segment.axes["mount_roll"] = {.kind = Motion::Kind::hold, .value = si(-90.0, "deg")};
  const auto findings = method().identify(simulated(plan), {}).findings;
  EXPECT_FALSE(has_finding(findings, "position_missing"));
  EXPECT_FALSE(has_finding(findings, "position_missing_other_twice"));
}

// In soaks shorter than the oven settles no sample is usable, nor needed.
TEST(FourPositions, AShortSoakIsNoSegmentThatIsMissing) {
  Plan plan = plan_of(figure_11, {-20.0, 20.0, 60.0});
  for (auto& segment : plan.schedule)
    if (segment.label == "soak") segment.duration = 1800.0;
  plan.rig.set_number("oven_time", 600.0, Unit::parse("s"));
  EXPECT_FALSE(has_finding(method().identify(simulated(plan), {}).findings, "segment_not_used"));
}

// Position 3 counted over windows of half the length: K_i follows from each N over its own H. Counting: 1/6 pulse^2
// over 2000 x 58 pulses is 3.5 ppm in one position, noise less; 5 standard deviations of the half difference.
TEST(FourPositions, EachCountIsDividedByItsOwnWindow) {
  Plan plan = plan_of(figure_11, {20.0});
  plan.rig.set_flag("ideal", true);
  set_truth(plan, "angle_random_walk", 0.0, "(m/s)/sqrt(h)");
  Evidence evidence{plan, {}};
  for (std::size_t k = 0; k < 4; ++k) {
    Plan part = plan;
    part.schedule = {plan.schedule[k]};
    part.sample_rate = k == 2 ? 2.0 : 1.0;
    evidence.recordings.push_back(simulate(part, k + 1, {}));
  }
  const auto estimate = method().identify(evidence, {});
  EXPECT_NEAR(value(estimate, "scale_factor_error"), 0.0, 15e-6);
}

TEST(FourPositions, AWindowThatHoldsTwoCountsByItsOwnTime) {
  Plan plan = plan_of(figure_11, {20.0});
  Evidence evidence = simulated(plan);
  const double reference = value(method().identify(evidence, {}), "scale_factor_error");
  // counts 30 and 31 in one: the stamp of the second is missing
  auto& channel = evidence.recordings[0].channels[0];
  auto stamps = std::make_shared<std::vector<double>>();
  std::vector<double> counts;
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    if (i == 31) {
      counts.back() += channel.values[i];
      continue;
    }
    stamps->push_back(static_cast<double>(i));
    counts.push_back(channel.values[i]);
  }
  channel.values = counts;
  channel.timeline = {0.0, 0.0, stamps};
  const auto estimate = method().identify(evidence, {});
  EXPECT_TRUE(has_finding(estimate.findings, "long_windows"));
  // the mean of the position is over 57 windows instead of 58: white noise of 1.7e-4 m/s^2/sqrt(Hz), 3 ppm of G each
  EXPECT_NEAR(value(estimate, "scale_factor_error"), reference, 5e-6);
}

TEST(FourPositions, TooFewTemperaturesAreSaidInWords) {
  const auto estimate = method().identify(simulated(plan_of(figure_11, {0.0, 40.0})), {});
  EXPECT_EQ(value_of(estimate.findings, "temperatures_limit_order", "temperatures"), 2.0);
  EXPECT_EQ(value_of(estimate.findings, "temperatures_limit_order", "order"), 1.0);
  EXPECT_EQ(value_of(estimate.findings, "temperatures_limit_order", "more"), 1.0);
  EXPECT_NE(find_parameter(estimate, "b_1"), nullptr);
  EXPECT_EQ(find_parameter(estimate, "b_2"), nullptr);
  EXPECT_TRUE(has_finding(estimate.findings, "repeatability_not_known"));
}

struct Held {
  int of = 0, clear = 0;  ///< intervals that hold the truth; tests in which the lack-of-fit test is clear
};

/// Bias at the five temperatures of noisy tests with `third` (u^3 - 3.4 u) [m/s^2] added to it, u from -2 to 2.
Held held(const Bench& exact, double third, double sd, std::uint64_t tests) {
  const Reduced sound = reduce(exact, 2, false, 0.0, nullptr);
  const auto cubic = [&](double t) {
    const double u = (t - 293.15) / 20.0;
    return third * (u * u * u - 3.4 * u);
  };
  Held out;
  for (std::uint64_t seed = 1; seed <= tests; ++seed) {
    Bench bench = exact;
    const RandomStream random(seed);
    for (std::size_t k = 0; k < bench.positions.size(); ++k)
      bench.positions[k].output += sd * random.normal(k) + cubic(bench.positions[k].temperature);
    const Reduced reduced = reduce(bench, 2, false, 0.0, nullptr);
    out.clear += reduced.misfit_ratio[bias] > 0.0 ? 1 : 0;
    const auto& polynomial = reduced.polynomial[bias];
    for (const double t : exact.group_temperature) {
      std::vector<double> weights(reduced.parameters.size());
      std::ranges::copy(powers(t, polynomial.count), weights.begin() + static_cast<std::ptrdiff_t>(polynomial.first));
      const double truth = at_temperature(sound.parameters, polynomial, t) + cubic(t);
      const double off = at_temperature(reduced.parameters, polynomial, t) - truth;
      const double freedom = freedom_of(reduced, weights);
      const double half = student_quantile(0.975, freedom) * std::sqrt(quadratic_form(weights, reduced.covariance));
      out.of += std::abs(off) < half ? 1 : 0;
    }
  }
  return out;
}

// A bias of third order in T that departs from a parabola by two standard deviations of the mean at one temperature at
// most: a lack of fit that is not clear. Of 300 intervals of 95 % (60 tests, five temperatures each) 285 hold the
// truth, with a standard deviation of 5 sqrt(60 0.0475) = 8.4 if the five of a test were one. Taken in only where the
// lack of fit is clear, the departure left 205.
TEST(FourPositions, ACourseThatIsNotClearlyOfThirdOrderIsInTheIntervals) {
  Plan plan = plan_of(figure_11, {-20.0, 0.0, 20.0, 40.0, 60.0});
  without_errors(plan);
  const auto once = plan.schedule;
  for (int run = 2; run <= 4; ++run)
    for (Segment segment : once) {
      segment.run = run;
      plan.schedule.push_back(segment);
    }
  const Bench exact = bench_of(simulated(plan), "accelerometer");
  const double sd = si(10.0, "ug"), of_mean = sd / std::sqrt(2.0 * 4.0);
  const Held sound = held(exact, 0.0, sd, 60), third = held(exact, 2.0 * of_mean / 2.4, sd, 60);
  EXPECT_EQ(sound.clear, 0);
  EXPECT_GT(sound.of, 285 - 4 * 8.4);
  EXPECT_LT(third.clear, 10);
  EXPECT_GT(third.of, 285 - 4 * 8.4);
}

TEST(FourPositions, ATemperatureThatMovesIsSeen) {
  Plan plan = plan_of(figure_11, {20.0});
  for (std::size_t k = 0; k < 4; ++k)
    plan.schedule[k].axes["temperature"] = {.kind = Motion::Kind::hold,
                                            .value = 293.15 + 0.45 * static_cast<double>(k)};
  plan.rig.set_number("oven_time", 1.0, Unit::parse("s"));
  EXPECT_TRUE(has_finding(method().identify(simulated(plan), {}).findings, "temperature_moves_in_set"));
}

// The unit is ten minutes behind the thermometer. After half an hour 3.9 K of 20 K remain by which an oven of 10 min
// moved the thermometer: 100 ppm of the scale factor. After 75 min, as the trial soaks, nothing is said.
TEST(FourPositions, AUnitThatFollowsTheThermometerLateIsSaid) {
  const auto said = [](double soak, double coefficient) {
    Plan plan = plan_of(figure_11, {-20.0, 0.0, 20.0, 40.0, 60.0});
    for (auto& segment : plan.schedule)
      if (segment.label == "soak") segment.duration = soak;
    plan.rig.set_number("oven_time", 600.0, Unit::parse("s"));
    set_truth(plan, "bias_temperature_coefficient", 0.0, "ug/K");
    set_truth(plan, "scale_factor_temperature_coefficient", coefficient, "ppm/K");
    const auto findings = method().identify(simulated(plan), {}).findings;
    return has_finding(findings, "soak_is_short") || has_finding(findings, "unit_follows_thermometer_late");
  };
  EXPECT_TRUE(said(2400.0, -25.0));
  EXPECT_FALSE(said(2400.0, 0.0));
  EXPECT_FALSE(said(7200.0, -25.0));
}

TEST(FourPositions, CompensatedOutputIsTheSpecificForce) {
  Plan plan = plan_of(figure_11, {0.0, 20.0, 40.0});
  without_errors(plan);
  set_truth(plan, "scale_factor_error", 400.0, "ppm");
  set_truth(plan, "misalignment_o", 60.0, "arcsec");
  const Evidence evidence = simulated(plan);
  Estimate estimate = method().identify(evidence, {});
  estimate.provenance.settings = plan.settings.texts();
  const auto done = compensate(estimate, evidence.recordings[0], nullptr);
  const Channel& channel = done.recording.channels[0];
  EXPECT_EQ(channel.kind, QuantityKind::specific_force);
  // position 3 at 40 degC, the last but one segment; 0.4e-3 of the bias in K_0 is of second order and is in nabla
  const std::size_t at = channel.values.size() - 90;
  EXPECT_NEAR(channel.values[at], -G, 1e-9);
  // the misalignment is not in (3.4): in the level positions its whole effect is an error, of which the sd tells
  const double stays = value(estimate, "misalignment") * G / std::sqrt(3.0);
  const auto& sd = find_channel(done.recording, "accelerometer.compensation_sd")->values;
  EXPECT_GT(std::abs(stays), si(50.0, "ug"));
  EXPECT_GE(sd[at], 0.999 * std::abs(stays));
  EXPECT_LT(sd[at], 1.5 * std::abs(stays) + si(10.0, "ug"));
  auto hot = evidence.recordings[0];
  for (auto& one : hot.channels)
    if (one.name == "temperature")
      for (double& t : one.values) t += 50.0;
  const auto findings = compensate(estimate, hot, nullptr).findings;
  // the oven follows its commands to 0.1 K
  ASSERT_EQ(estimate.models.at(0).covered.size(), 2u);
  EXPECT_NEAR(estimate.models[0].covered[1].least, 273.15, 0.1);
  EXPECT_NEAR(estimate.models[0].covered[1].greatest, 313.15, 0.1);
  EXPECT_NEAR(value_of(findings, "extrapolated", "share"), 1.0, 0.6);  // all but those of 0 degC, which become 50
}

}  // namespace
}  // namespace tumble::accelerometer_four_position_test
