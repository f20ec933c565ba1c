// Against the closed forms of evenly spaced positions (harmonics of the angle), in units of the local g:
//
//   E/K_1 = (K_0 + K_2/2) + (1 + 3 K_3/4) sin th + delta cos th - (K_2/2) cos 2th + (K_ip/2) sin 2th - (K_3/4) sin 3th

#include <gtest/gtest.h>

#include <utility>

#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/positions.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/reduce/accelerometer/scale_factor.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::accelerometer_tumble_test {
namespace {

using namespace testing;
using testing::Position;

const Method& method() { return find_method("accelerometer_tumble"); }

const Coefficients unit{.k_1 = 0.8,
                        .k_0 = 3.1e-3,
                        .k_2 = 18e-6,
                        .k_3 = -9e-6,
                        .k_ip = 25e-6,
                        .k_io = -14e-6,
                        .delta_o = 4.6e-4,
                        .delta_p = -2.9e-4};

constexpr double rounding = 1e-11;  // of noise-free volts, over regressors of size 1

struct Answer {
  Evidence evidence;
  Estimate estimate;
  double operator()(const std::string& name) const { return local(estimate, name, evidence); }
};

Answer answer(const std::vector<Position>& positions, const Coefficients& c = unit,
              const std::function<double(double)>& error = nullptr) {
  Answer out{evidence_of(positions, c, error), {}};
  out.estimate = method().identify(out.evidence, {});
  return out;
}

/// The same with equal weights.
Answer even_answer(const std::vector<Position>& positions, const Coefficients& c,
                   const std::function<double(double)>& error = nullptr) {
  Answer out{evenly_weighted(evidence_of(positions, c, error)), {}};
  out.estimate = method().identify(out.evidence, {});
  return out;
}

// S_k, C_k of E over n positions: the closed forms for both mounts.
struct Harmonics {
  double b0 = 0.0, s[4] = {}, c[4] = {};
};

Harmonics harmonics(int n, const Coefficients& unit, bool second) {
  Harmonics h;
  for (int r = 0; r < n; ++r) {
    const double th = 2.0 * std::numbers::pi * r / n;
    const double e = second ? unit(std::sin(th), 0.0, std::cos(th)) : unit(std::sin(th), std::cos(th), 0.0);
    h.b0 += e / n;
    for (int k = 1; k < 4; ++k) {
      h.s[k] += 2.0 / n * e * std::sin(k * th);
      h.c[k] += (2 * k == n ? 1.0 : 2.0) / n * e * std::cos(k * th);
    }
  }
  return h;
}

TEST(AccelerometerTumble, ManyPositionsGiveTheClosedFormInEitherMount) {
  for (const int n : {7, 8, 9, 12, 24})
    for (const bool second : {false, true}) {
      const auto h = harmonics(n, unit, second);
      const auto found = answer(turn(n, second ? -90.0 : 0.0));
      const double k_1 = h.s[1] + 3.0 * h.s[3];
      EXPECT_NEAR(found("scale_factor"), k_1, rounding) << n;
      EXPECT_NEAR(found("third_order_coefficient"), -4.0 * h.s[3] / k_1, 10.0 * rounding) << n;
      EXPECT_NEAR(found("second_order_coefficient"), -2.0 * h.c[2] / k_1, rounding) << n;
      EXPECT_NEAR(found("bias"), (h.b0 + h.c[2]) / k_1, rounding) << n;
      EXPECT_NEAR(found(second ? "cross_coupling_io" : "cross_coupling_ip"), 2.0 * h.s[2] / k_1, rounding) << n;
      EXPECT_NEAR(found(second ? "misalignment_p" : "misalignment_o"), (second ? -1.0 : 1.0) * h.c[1] / k_1, rounding);
      EXPECT_TRUE(std::isnan(found(second ? "cross_coupling_ip" : "cross_coupling_io")));
      EXPECT_TRUE(std::isnan(found(second ? "misalignment_o" : "misalignment_p")));
      // and the closed form gives the truth
      EXPECT_NEAR(found("scale_factor"), unit.k_1, rounding);
      EXPECT_NEAR(found("third_order_coefficient"), unit.k_3, 10.0 * rounding);
      EXPECT_NEAR(found("bias"), unit.k_0, rounding);
    }
}

// (3.5): K = (E_1 - E_3)/2, nabla = (E_1 + E_3)/(2 K), K_0 = (E_2 + E_4)/(2 K), K_2 = (E_1 + E_3 - E_2 - E_4)/(2 K),
// theta_t = (E_2 - E_4)/(2 K) with p up in position 2, in units of the local g.
TEST(AccelerometerTumble, FourPositionsAreTheFourPositionFormulas) {
  const auto found = answer({{90, 0}, {0, 0}, {270, 0}, {180, 0}});
  const double e1 = unit(1, 0, 0), e2 = unit(0, 1, 0), e3 = unit(-1, 0, 0), e4 = unit(0, -1, 0);
  const double k = (e1 - e3) / 2.0;
  EXPECT_NEAR(found("scale_factor"), k, rounding);
  EXPECT_NEAR(found("scale_factor"), unit.k_1 * (1.0 + unit.k_3), rounding);
  EXPECT_NEAR(found("bias"), (e2 + e4) / (2.0 * k), rounding);
  EXPECT_NEAR(found("second_order_coefficient"), (e1 + e3 - e2 - e4) / (2.0 * k), rounding);
  EXPECT_NEAR(found("misalignment_o"), (e2 - e4) / (2.0 * k), rounding);
  EXPECT_NEAR(found("bias") + found("second_order_coefficient"), (e1 + e3) / (2.0 * k), rounding);  // nabla
  EXPECT_EQ(find_parameter(found.estimate, "third_order_coefficient"), nullptr);
  EXPECT_EQ(find_parameter(found.estimate, "cross_coupling_ip"), nullptr);
  const auto& findings = found.estimate.findings;
  EXPECT_EQ(text_of(findings, "not_distinguished", "term"), "third_order_coefficient (K_3)");
  EXPECT_EQ(text_of(findings, "not_distinguished", "others"), "scale_factor");
  EXPECT_EQ(text_of(findings, "not_distinguished", "meanings"), "K_1 (1 + K_3)");
  const auto& contains = find_parameter(found.estimate, "scale_factor")->contains;  // K_1 + weight K_3
  ASSERT_EQ(contains.size(), 1u);
  EXPECT_EQ(contains[0].name, "third_order_coefficient");
  const double g = gravity(*found.evidence.plan.site);
  EXPECT_NEAR(contains[0].weight, find_parameter(found.estimate, "scale_factor")->value * g * g, 1e-9 * g * g);
  // Along +-p the hinge's stiffness K_pp a_p^2 looks like bias, and in the quadratic term it is subtracted.
  const auto& hinge = find_parameter(found.estimate, "bias")->contains;
  ASSERT_EQ(hinge.size(), 1u);
  EXPECT_EQ(hinge[0].name, "second_order_pp");
  EXPECT_NEAR(hinge[0].weight, g * g, 1e-9 * g * g);
  const auto& subtracted = find_parameter(found.estimate, "second_order_coefficient")->contains;
  ASSERT_EQ(subtracted.size(), 1u);
  EXPECT_EQ(subtracted[0].name, "second_order_pp");
  EXPECT_NEAR(subtracted[0].weight, -1.0, 1e-9);
  EXPECT_EQ(text_of(findings, "not_shown", "terms"), "cross_coupling_io, cross_coupling_ip, misalignment_p");
  EXPECT_EQ(value_of(findings, "no_position_to_spare", "positions"), 4.0);
  EXPECT_EQ(value_of(findings, "no_position_to_spare", "parameters"), 4.0);
}

TEST(AccelerometerTumble, FivePositionsWithholdTheCrossCoupling) {
  const auto found = answer(turn(5));
  EXPECT_EQ(find_parameter(found.estimate, "cross_coupling_ip"), nullptr);
  EXPECT_EQ(text_of(found.estimate.findings, "coefficient_mixed_with_third_order", "parameter"), "cross_coupling_ip");
  EXPECT_EQ(text_of(found.estimate.findings, "coefficient_mixed_with_third_order", "combination"), "K_ip + 0.5 K_3");
  EXPECT_NEAR(found("scale_factor"), unit.k_1 * (1.0 + 0.75 * unit.k_3), rounding);
  EXPECT_EQ(found.estimate.covariance.rows, found.estimate.parameters.size());
}

TEST(AccelerometerTumble, SixPositionsHideTheThirdOrderInTheScaleFactor) {
  const auto found = answer(turn(6));
  EXPECT_NEAR(found("cross_coupling_ip"), unit.k_ip / (1.0 + 0.75 * unit.k_3), rounding);
  EXPECT_NEAR(found("scale_factor"), unit.k_1 * (1.0 + 0.75 * unit.k_3), rounding);
  EXPECT_EQ(find_parameter(found.estimate, "third_order_coefficient"), nullptr);
  EXPECT_EQ(text_of(found.estimate.findings, "not_distinguished", "meanings"), "K_1 (1 + 0.75 K_3)");
}

TEST(AccelerometerTumble, IrregularPositionsInBothMountsGiveAll) {
  std::vector<Position> positions;
  for (const double angle : {3.0, 41.0, 87.0, 111.0, 158.0, 204.0, 260.0, 305.0, 340.0}) {
    positions.push_back({angle, 0.0});
    positions.push_back({angle + 10.0, -90.0});
  }
  const auto found = answer(positions);
  EXPECT_NEAR(found("scale_factor"), unit.k_1, rounding);
  EXPECT_NEAR(found("cross_coupling_ip"), unit.k_ip, rounding);
  EXPECT_NEAR(found("cross_coupling_io"), unit.k_io, rounding);
  EXPECT_NEAR(found("misalignment_o"), unit.delta_o, rounding);
  EXPECT_NEAR(found("misalignment_p"), unit.delta_p, rounding);
  EXPECT_NEAR(found("third_order_coefficient"), unit.k_3, 10.0 * rounding);
}

TEST(AccelerometerTumble, WhatOneGHides) {
  Coefficients hinge = unit;
  hinge.k_pp = -hinge.k_2;  // an elastic hinge: K_2 comes out twice
  hinge.k_oo = 7e-6;
  hinge.k_po = 50e-6;
  const auto first = answer(turn(12), hinge), second = answer(turn(12, -90.0), hinge);
  EXPECT_NEAR(first("bias"), hinge.k_0 + hinge.k_pp, rounding);
  EXPECT_NEAR(first("second_order_coefficient"), 2.0 * hinge.k_2, rounding);
  EXPECT_EQ(text_of(first.estimate.findings, "hinge_hidden_at_one_g", "symbol"), "K_pp");
  EXPECT_EQ(text_of(first.estimate.findings, "hinge_hidden_at_one_g", "meanings"),
            "bias + K_pp, second_order_coefficient - K_pp");
  EXPECT_TRUE(has_finding(first.estimate.findings, "products_across_not_excited"));
  EXPECT_FALSE(says(first.estimate.findings, "K_oo"));
  EXPECT_NEAR(second("bias"), hinge.k_0 + hinge.k_oo, rounding);
  EXPECT_NEAR(second("second_order_coefficient"), hinge.k_2 - hinge.k_oo, rounding);
  EXPECT_EQ(text_of(second.estimate.findings, "term_hidden_at_one_g", "symbol"), "K_oo");
  EXPECT_EQ(text_of(second.estimate.findings, "term_hidden_at_one_g", "meanings"),
            "bias + K_oo, second_order_coefficient - K_oo");

  auto both = turn(12);
  for (const auto& position : turn(12, -90.0)) both.push_back(position);
  const auto found = answer(both, hinge);
  EXPECT_NEAR(found("second_order_pp"), hinge.k_pp - hinge.k_oo, rounding);
  EXPECT_NEAR(found("bias"), hinge.k_0 + hinge.k_oo, rounding);
  EXPECT_NEAR(found("second_order_coefficient"), hinge.k_2 - hinge.k_oo, rounding);
  EXPECT_EQ(text_of(found.estimate.findings, "term_hidden_at_one_g", "meanings"),
            "bias + K_oo, second_order_coefficient - K_oo, second_order_pp - K_oo");
}

// sin|sin| = (8/pi)(sin/3 - sin3/15 - ...): on 24 positions 0.34 of it goes into K_1, 0.68 into K_3. The sums over 24
// positions differ from the integrals by the aliases of its harmonics 21 and beyond, below 0.005.
TEST(AccelerometerTumble, AnOddQuadraticTermShowsAsThirdOrderAndScaleFactor) {
  Coefficients odd = unit;
  odd.k_oq = 100e-6;
  const auto found = even_answer(turn(24), odd);
  EXPECT_NEAR((found("third_order_coefficient") - unit.k_3) / odd.k_oq, 0.68, 0.005);
  EXPECT_NEAR((found("scale_factor") / unit.k_1 - 1.0) / odd.k_oq, 0.34, 0.005);
  EXPECT_TRUE(says(found.estimate.findings, "scale_factor (1 + 0.34 K_oq), third_order_coefficient + 0.68 K_oq"));
}

// Harmonics of the head's angle error, d = 20 arcsec: 9.7e-5 rad, whose square is 1e-8 and a thousandth of the effect
// is 1e-7. Second order and products with the coefficients (1e-3) stay below 3e-7.
struct HeadError {
  const char* name;
  std::function<double(double, double)> error;  ///< of size d at angle th
  double k_0, k_1, k_2, k_3, k_ip, delta_o;     ///< shifts per d; of K_1 relative
};

TEST(AccelerometerTumble, ErrorsOfTheHeadGoWhereTheirHarmonicsSay) {
  const HeadError errors[] = {{"constant", [](double d, double) { return d; }, 0, 0, 0, 0, 0, 1},
                              {"1c", [](double d, double th) { return d * std::cos(th); }, 1, 0, -1, 0, 0, 0},
                              {"1s", [](double d, double th) { return d * std::sin(th); }, 0, 0, 0, 0, 1, 0},
                              {"2c", [](double d, double th) { return d * std::cos(2 * th); }, 0, 0, 0, 0, 0, 0.5},
                              {"2s", [](double d, double th) { return d * std::sin(2 * th); }, 0, 2, 0, -2, 0, 0},
                              {"3c", [](double d, double th) { return d * std::cos(3 * th); }, 0.5, 0, -1, 0, 0, 0},
                              {"3s", [](double d, double th) { return d * std::sin(3 * th); }, 0, 0, 0, 0, 1, 0},
                              {"4s", [](double d, double th) { return d * std::sin(4 * th); }, 0, 1.5, 0, -2, 0, 0}};
  const double d = 20.0 * arcsec;
  for (const auto& one : errors) {
    const auto found = even_answer(turn(12), unit, [&](double th) { return one.error(d, th); });
    const double tolerance = 7e-7;
    EXPECT_NEAR(found("bias") - unit.k_0, one.k_0 * d, tolerance) << one.name;
    EXPECT_NEAR(found("scale_factor") / unit.k_1 - 1.0, one.k_1 * d, tolerance) << one.name;
    EXPECT_NEAR(found("second_order_coefficient") - unit.k_2, one.k_2 * d, tolerance) << one.name;
    EXPECT_NEAR(found("third_order_coefficient") - unit.k_3, one.k_3 * d, tolerance) << one.name;
    EXPECT_NEAR(found("cross_coupling_ip") - unit.k_ip, one.k_ip * d, tolerance) << one.name;
    EXPECT_NEAR(found("misalignment_o") - unit.delta_o, one.delta_o * d, tolerance) << one.name;
  }
}

TEST(AccelerometerTumble, FourPositionsTakeTheHarmonicsOfTheHeadOtherwise) {
  const double d = 20.0 * arcsec;
  const auto d_2s = answer(turn(4), unit, [&](double th) { return d * std::sin(2 * th); });
  EXPECT_NEAR(d_2s("scale_factor") / unit.k_1, 1.0 + unit.k_3, 1e-8);
  const auto d_2c = answer(turn(4), unit, [&](double th) { return d * std::cos(2 * th); });
  EXPECT_NEAR(d_2c("misalignment_o") - unit.delta_o, d, 3e-7);
  const auto d_3c = answer(turn(4), unit, [&](double th) { return d * std::cos(3 * th); });
  EXPECT_NEAR(d_3c("bias") - unit.k_0, d, 3e-7);
  EXPECT_NEAR(d_3c("second_order_coefficient") - unit.k_2, -d, 3e-7);
}

/// What the rig's own error of one standard deviation does, from the budget.
double budget(const Estimate& estimate, const std::string& source, const std::string& name) {
  const Parameter* p = find_parameter(estimate, name);
  for (const auto& line : estimate.budget)
    if (line.source == source && p)
      return std::sqrt(line.variance(static_cast<std::size_t>(p - estimate.parameters.data())));
  ADD_FAILURE() << "no " << source << " of " << name;
  return std::nan("");
}

/// The trial on a head that is exact but for `option`, 1 arcsec.
Estimate with_error(const char* option) {
  Evidence evidence = trial_of(method(), 1).evidence;
  auto& rig = evidence.plan.rig;
  for (const auto& one : find_rig("dividing_head").options())
    if (one.name.ends_with("_sd")) rig.set_number(one.name, 0.0, Unit::parse(one.unit));
  rig.set_number(option, arcsec, Unit::parse("arcsec"));
  evidence.recordings = {simulate(evidence.plan, 5, {})};
  return method().identify(evidence, {});
}

// The same from the rig's own errors, through the budget: 1 arcsec twice per turn is 2 x 4.848e-6 = 9.7 ppm of K_1 and
// 9.7 ug/g^3 of K_3. The positions are weighted nearly alike, so that the harmonics hold to 2 %.
TEST(AccelerometerTumble, AnArcsecTwicePerTurnIs97PpmAnd97MicroG) {
  const double g = gravity(*trial_of(method(), 1).evidence.plan.site);
  const auto twice = with_error("angle_twice_sd"), once = with_error("angle_once_sd");
  const std::string c = ", cosine", s = ", sine", at = "angle error of head ";
  EXPECT_NEAR(budget(twice, at + "twice per turn" + s, "scale_factor") / value(twice, "scale_factor"), 9.7e-6, 2e-7);
  EXPECT_NEAR(budget(twice, at + "twice per turn" + s, "third_order_coefficient") * g * g, 9.7e-6, 2e-7);
  EXPECT_NEAR(budget(once, at + "once per turn" + c, "bias") / g, arcsec, 0.02 * arcsec);
  EXPECT_NEAR(budget(once, at + "once per turn" + c, "second_order_coefficient") * g, arcsec, 0.02 * arcsec);
}

TEST(AccelerometerTumble, TheZeroOfTheHeadIsInTheMisalignmentUnlessTheUnitIsTurned) {
  const double d = 20.0 * arcsec;
  const auto zero = [d](double) { return d; };
  const auto alone = answer(turn(8), unit, zero);
  EXPECT_TRUE(has_finding(alone.estimate.findings, "zero_of_head_in_misalignment"));
  auto positions = turn(8);
  for (const auto& position : turn(8, 180.0)) positions.push_back(position);
  // an ideal head but for its zero, which the estimate then knows of
  Evidence evidence = evidence_of(positions, unit, zero);
  evidence.plan.rig.set_flag("ideal", false);
  for (const auto& option : find_rig("dividing_head").options())
    if (option.name.ends_with("_sd")) evidence.plan.rig.set_number(option.name, 0.0, Unit::parse(option.unit));
  evidence.plan.rig.set_number("index_zero_sd", si(30.0, "arcsec"), Unit::parse("arcsec"));
  const auto estimate = method().identify(evidence, {});
  EXPECT_NEAR(local(estimate, "misalignment_o", evidence), unit.delta_o, 1e-7);
  EXPECT_FALSE(has_finding(estimate.findings, "zero_of_head_in_misalignment"));
}

// K_1 pulse/s/g is per standard g; where g is G, K_1 G/g0 per local g, K_0 g0/G, K_2 G/g0, K_3 (G/g0)^2.
TEST(AccelerometerTumble, StatesTheCoefficientsPerLocalGToo) {
  const auto found = answer(turn(12));
  const Table* table = find_table(found.estimate, "local_g");
  ASSERT_NE(table, nullptr);
  const auto cell = [&](const std::string& name) {
    for (std::size_t c = 0; c < table->columns.size(); ++c)
      if (table->columns[c].name == name) return table->columns[c].unit.from_si(std::get<double>(table->rows[0][c]));
    return std::nan("");
  };
  EXPECT_NEAR(cell("scale_factor"), unit.k_1, 1e-10);
  EXPECT_NEAR(cell("bias"), 1e3 * unit.k_0, 1e-7);
  EXPECT_NEAR(cell("second_order_coefficient"), 1e6 * unit.k_2, 1e-4);
  EXPECT_NEAR(cell("third_order_coefficient"), 1e6 * unit.k_3, 1e-3);
  EXPECT_NEAR(cell("misalignment_o"), unit.delta_o / arcsec, 1e-5);
}

// b_j/(1 + d) and K_1 = nominal (1 + d): the covariance is that of the differential.
TEST(AccelerometerTumble, TheCovarianceIsThatOfTheNormalisedCoefficients) {
  linear::Solution solution;
  solution.columns =
      linear::terms_of("pendulous_accelerometer", defaults(find_model("pendulous_accelerometer").constants()),
                       {"bias", "scale_factor_error"});
  const double b = 0.03, d = -0.2, nominal = 5.0;
  solution.fit.parameters = {b, d};
  solution.fit.covariance = Matrix(2, 2);
  solution.fit.covariance.values = {4e-6, 1e-6, 1e-6, 9e-6};
  solution.fit.sources = {{"noise", solution.fit.covariance}};
  accelerometer::normalise(solution, nominal, {});
  const double over = 1.0 / (1.0 + d), slope = -b * over * over;
  EXPECT_NEAR(solution.fit.parameters[0], b * over, 1e-15);
  EXPECT_NEAR(solution.fit.parameters[1], 4.0, 1e-15);
  EXPECT_NEAR(solution.fit.covariance(0, 0), over * over * 4e-6 + 2.0 * over * slope * 1e-6 + slope * slope * 9e-6,
              1e-18);
  EXPECT_NEAR(solution.fit.covariance(0, 1), nominal * (over * 1e-6 + slope * 9e-6), 1e-18);
  EXPECT_NEAR(solution.fit.sources[0].covariance(1, 1), 25.0 * 9e-6, 1e-18);
  EXPECT_EQ(solution.columns[1].name, "scale_factor");
}

// Bad input

TEST(AccelerometerTumble, APositionUnderTwoLabelsIsARepeat) {
  auto positions = turn(8);
  positions.push_back({45.0 + 360.0, 0.0});  // the label differs, the place does not
  const auto found = answer(positions);
  EXPECT_EQ(text_of(found.estimate.findings, "one_position_of_several_labels", "segments"),
            "'45.000000 roll 0.000000', '405.000000 roll 0.000000'");
}

TEST(AccelerometerTumble, ALabelOfTwoPositionsIsDoubtful) {
  Evidence evidence = evidence_of(turn(8), unit);
  for (const std::size_t k : {1u, 2u}) {
    evidence.plan.schedule[k].label = "same";
    evidence.recordings[0].marks[k].label = "same";
  }
  EXPECT_EQ(text_of(method().identify(evidence, {}).findings, "one_label_of_several_positions", "label"), "same");
}

TEST(AccelerometerTumble, AUnitThatClipsIsRefused) {
  Evidence evidence = evidence_of(turn(12), unit);
  for (auto& v : evidence.recordings[0].channels[0].values) v = std::min(v, 0.75 * unit.k_1);
  const auto said = refusal(method(), evidence);
  EXPECT_NE(said.find("show the same output, the greatest of all"), std::string::npos) << said;
  EXPECT_NE(said.find("'90.000000 roll 0.000000'"), std::string::npos) << said;
}

// only the positions at +-1 g are clipped: nothing else shows the same
TEST(AccelerometerTumble, AUnitThatClipsAtItsGreatestAloneIsRefused) {
  Evidence evidence = evidence_of(turn(12), unit);
  for (auto& v : evidence.recordings[0].channels[0].values) v = std::clamp(v, -0.95 * unit.k_1, 0.95 * unit.k_1);
  const auto said = refusal(method(), evidence);
  EXPECT_NE(said.find("'90.000000 roll 0.000000', '270.000000 roll 0.000000', where the specific force is greatest"),
            std::string::npos)
      << said;
}

/// Four positions with noise of 100 uV, whose output ends at this share of 1 g.
Evidence four_clipped_at(double share, double step) {
  Evidence evidence = evidence_of(turn(4), unit);
  auto& values = evidence.recordings[0].channels[0].values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] += 1e-4 * RandomStream(4711).normal(i);
    if (step > 0.0) values[i] = step * std::round(values[i] / step);
    values[i] = std::clamp(values[i], -share * unit.k_1, share * unit.k_1);
  }
  return evidence;
}

// With four positions nothing else shows that the scale factor is 1 % low: a position that does not scatter does, and
// where no position scatters (steps of 1 mV, ten times the noise) ends that an offset of 3 mg does not move.
TEST(AccelerometerTumble, FourPositionsThatClipJustBelowOneGAreNamed) {
  const auto found = [](double share, double step, const char* code) {
    const auto findings = method().identify(four_clipped_at(share, step), {}).findings;
    const Finding* finding = finding_of(findings, code);
    return finding != nullptr && finding->severity == Finding::Severity::error;
  };
  EXPECT_TRUE(found(0.99, 0.0, "one_value_in_segment"));
  EXPECT_TRUE(found(0.99, 1e-3, "ends_equal_and_opposite"));
  for (const double step : {0.0, 1e-3})
    for (const char* code : {"one_value_in_segment", "ends_equal_and_opposite"}) EXPECT_FALSE(found(1.2, step, code));
}

// One level position cannot distinguish an offset from a misalignment: 3 mrad of it beside a bias of nothing is no
// clipping.
TEST(AccelerometerTumble, AMisalignmentInOneLevelPositionIsNoClipping) {
  const std::vector<Position> positions{{0.0}, {90.0}, {270.0}};
  EXPECT_FALSE(
      has_finding(answer(positions, {.k_1 = 0.8, .delta_o = 3e-3}).estimate.findings, "ends_equal_and_opposite"));
}

/// Noise of this size [V], and a drift [V/h].
void disturb(double noise, double drift, std::uint64_t seed, Evidence& evidence) {
  auto& values = evidence.recordings[0].channels[0].values;
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] += noise * RandomStream(seed).normal(i) + drift * static_cast<double>(i) / 3600.0;
}

// Four positions leave no residual: the drift shows within them alone. 8 mV/h are 89 uV over a position of 40 s, noise
// of 10 uV knows the rise to 10 uV sqrt(12/40) = 5.5 uV in each. Of 200 sound tests none is accused.
TEST(AccelerometerTumble, ADriftWithinFewPositionsIsSaid) {
  const auto said = [](double drift, std::uint64_t seed) {
    Evidence evidence = evidence_of(turn(4), unit);
    disturb(1e-5, drift, seed, evidence);
    return has_finding(method().identify(evidence, {}).findings, "output_drifts_within_segments");
  };
  for (std::uint64_t seed = 0; seed < 5; ++seed) EXPECT_TRUE(said(8e-3, seed)) << seed;
  for (std::uint64_t seed = 0; seed < 200; ++seed) EXPECT_FALSE(said(0.0, seed)) << seed;
}

/// The evidence of a recording whose samples come so many places earlier (+) or later (-) than its marks say.
Evidence misplaced(int samples, std::uint64_t seed) {
  Evidence evidence = evidence_of(turn(12), unit);
  disturb(2e-5, 0.0, seed, evidence);
  auto& values = evidence.recordings[0].channels[0].values;
  for (; samples > 0; --samples) {
    values.erase(values.begin());
    values.push_back(values.back());
  }
  for (; samples < 0; ++samples) {
    values.pop_back();
    values.insert(values.begin(), values.front());
  }
  return evidence;
}

/// What the findings say of the shift [s]: 0 where there is none of this code.
double shift_of(const Findings& findings, const std::string& code) {
  const Finding* finding = finding_of(findings, code);
  if (finding == nullptr) return 0.0;
  EXPECT_EQ(finding->severity, Finding::Severity::error);
  return std::get<double>(finding->values.at(0).value);
}

// One sample of the next position is up to 0.4 V away, where the noise is 20 uV: its share of the way is 1 to 1e-4. The
// way of the head and the settling of 2 s hide what is wrong at the begin of a recording that is a few seconds early.
TEST(AccelerometerTumble, ARecordingThatBeginsLateOrEarlyIsSaid) {
  for (const int samples : {1, 2, 5, -10, -12}) {
    const auto findings = method().identify(misplaced(samples, 7), {}).findings;
    EXPECT_NEAR(shift_of(findings, "segments_end_in_next") - shift_of(findings, "segments_begin_in_last"), samples,
                1e-3);
  }
}

TEST(AccelerometerTumble, ARecordingThatBeginsInTimeIsNotAccused) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const auto findings = method().identify(misplaced(0, seed), {}).findings;
    for (const char* code : {"segments_end_in_next", "segments_begin_in_last", "segments_settle"})
      EXPECT_FALSE(has_finding(findings, code)) << code << seed;
  }
}

// Steps of 1 mV and a tenth of that as noise: the means are off by up to half a step, however long they are. The
// intervals of 100 tests, each with a bias of its own, hold: 4 sigma of 100 are 0.087.
TEST(AccelerometerTumble, RoundingOfACoarseOutputIsInTheIntervals) {
  const char* names[] = {"bias", "second_order_coefficient", "third_order_coefficient", "misalignment_o"};
  double held = 0.0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Coefficients truth = unit;
    truth.k_0 = 5e-3 * RandomStream(99).normal(seed);
    Evidence evidence = evidence_of(turn(8), truth);
    disturb(1e-4, 0.0, 1000 + seed, evidence);
    for (double& v : evidence.recordings[0].channels[0].values) v = 1e-3 * std::round(v / 1e-3);
    const auto estimate = method().identify(evidence, {});
    EXPECT_TRUE(has_finding(estimate.findings, "rounding_moves_means"));
    const double g = gravity(*evidence.plan.site);
    const double values[] = {truth.k_0 * g, truth.k_2 / g, truth.k_3 / (g * g), truth.delta_o};
    for (std::size_t k = 0; k < 4; ++k) {
      const auto index = static_cast<std::size_t>(find_parameter(estimate, names[k]) - estimate.parameters.data());
      const Parameter& p = estimate.parameters[index];
      const double half = student_quantile(0.975, p.degrees_of_freedom) * standard_uncertainty(estimate, index);
      held += std::abs(p.value - values[k]) <= half ? 1.0 / 400.0 : 0.0;
    }
  }
  EXPECT_GT(held, 0.95 - 0.087);
}

Evidence counted(double pulses_per_g) {
  Coefficients counter = unit;
  counter.k_1 = pulses_per_g;
  Evidence evidence = evidence_of(turn(12), counter);
  auto& channel = evidence.recordings[0].channels[0];
  channel.unit = Unit::parse("pulse");
  channel.kind = QuantityKind::count;
  double total = 0.0;
  for (auto& v : channel.values) {
    const double before = std::floor(total);
    total += v;
    v = std::floor(total) - before;
  }
  return evidence;
}

TEST(AccelerometerTumble, ACounterThatOverflowsIsRefused) {
  Evidence whole = counted(40000.0);
  EXPECT_NO_THROW(method().identify(whole, {}));
  Evidence evidence = whole;
  for (auto& v : evidence.recordings[0].channels[0].values)
    v = v > 32767.0 ? v - 65536.0 : v < -32768.0 ? v + 65536.0 : v;
  const auto said = refusal(method(), evidence);
  EXPECT_NE(said.find("by 65536, a power of two: the counter overflowed"), std::string::npos) << said;
  // a few windows of a position
  evidence = counted(30000.0);
  evidence.recordings[0].channels[0].values[40 * 3 + 30] -= 65536.0;
  EXPECT_NE(refusal(method(), evidence).find("1 count off the others by 65536"), std::string::npos);
}

TEST(AccelerometerTumble, AHeadThatCountsTheOtherWayIsNamed) {
  const auto found = answer(turn(12), unit, [](double th) { return -2.0 * th; });
  EXPECT_NEAR(found("scale_factor"), -unit.k_1, 1e-3);
  EXPECT_TRUE(has_finding(found.estimate.findings, "scale_factor_negative"));
}

TEST(AccelerometerTumble, APositionThatWasNotGoneToIsNamed) {
  Evidence evidence = trial_of(method(), 1).evidence;
  auto& values = evidence.recordings[0].channels[0].values;
  std::copy_n(values.begin() + 640, 60, values.begin() + 740);  // at 0 deg, the head long at rest
  std::copy_n(values.begin() + 640, 40, values.begin() + 700);
  const auto estimate = method().identify(evidence, {});
  EXPECT_EQ(text_of(estimate.findings, "position_disagrees_and_repeats", "segment"), "roll -90 at 60");
  EXPECT_EQ(text_of(estimate.findings, "position_disagrees_and_repeats", "other"), "roll -90 at 0");
  EXPECT_GT(value_of(estimate.findings, "position_disagrees_and_repeats", "times"), 5.0);
}

TEST(AccelerometerTumble, TwoPositionsThatAreExchangedAreNamed) {
  Evidence evidence = trial_of(method(), 1).evidence;
  auto& values = evidence.recordings[0].channels[0].values;
  std::swap_ranges(values.begin() + 700, values.begin() + 800, values.begin() + 1000);  // 60 deg and 240 deg
  const auto estimate = method().identify(evidence, {});
  EXPECT_EQ(text_of(estimate.findings, "outputs_exchanged", "segment"), "roll -90 at 60");
  EXPECT_EQ(text_of(estimate.findings, "outputs_exchanged", "other"), "roll -90 at 240");
}

// Three degrees of freedom: the best of nine positions to leave out improves the rest several times by luck alone.
TEST(AccelerometerTumble, FewPositionsThatAgreeAreNotAccused) {
  Plan plan = trial_of(method(), 1).evidence.plan;
  plan.schedule.erase(plan.schedule.begin() + 9, plan.schedule.end());
  for (std::size_t k = 0; k < 9; ++k) {
    plan.schedule[k].label = std::to_string(k);
    plan.schedule[k].axes["head"].value = si(40.0 * static_cast<double>(k), "deg");
    plan.schedule[k].axes["mount_roll"].value = 0.0;
  }
  int accused = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const auto estimate = method().identify({plan, {simulate(plan, seed, {})}, {}}, {});
    for (const char* code : {"position_disagrees", "position_disagrees_and_repeats", "outputs_exchanged"})
      accused += has_finding(estimate.findings, code);
  }
  EXPECT_LE(accused, 1);  // one in ten thousand is meant, of normal residuals
}

TEST(AccelerometerTumble, AScaleFactorThatTheAngleOfTheHeadSpoilsIsDoubted) {
  const auto found = answer(turn(12), unit, [](double) { return si(1.0, "deg"); });
  EXPECT_TRUE(has_finding(found.estimate.findings, "misalignment_changes_scale_factor"));
}

/// Counts of two power-ups that are equal to the last one, over evenly spaced positions and the first once more.
Evidence repeated_power_up(int positions, int seconds) {
  auto places = turn(positions);
  places.push_back({0.0, 0.0});
  Evidence evidence = evidence_of(places, unit);
  evidence.plan.rig.set_flag("ideal", false);
  const auto schedule = std::exchange(evidence.plan.schedule, {});
  Recording& recording = evidence.recordings[0];
  Channel& channel = recording.channels[0];
  channel.unit = Unit::parse("pulse");
  channel.kind = QuantityKind::count;
  channel.values.clear();
  recording.marks.clear();
  for (int run = 1; run <= 2; ++run)
    for (std::size_t k = 0; k < places.size(); ++k) {
      recording.marks.push_back({schedule[k].label, static_cast<double>(channel.values.size()), run});
      evidence.plan.schedule.push_back(schedule[k]);
      evidence.plan.schedule.back().run = run;
      evidence.plan.schedule.back().duration = seconds;
      const double pulses = std::round(10000.0 * std::sin(si(places[k].angle, "deg")));
      for (int i = 0; i < seconds; ++i) channel.values.push_back(pulses + 20.0 + (i * 7) % 5 - 2.0);
    }
  return evidence;
}

// Rounding put a variance of the slow noise below zero, since the two power-ups cancel, and made the answer NaN. With
// sines rounded to 0.5 pulse, K_1 per local g is 10000 to 1 pulse.
TEST(AccelerometerTumble, APowerUpThatRepeatsAnotherExactlyIsSoundData) {
  for (const auto& [positions, seconds] : {std::pair{6, 40}, std::pair{8, 60}}) {
    const Evidence evidence = repeated_power_up(positions, seconds);
    const auto estimate = method().identify(evidence, {});
    EXPECT_NEAR(value(estimate, "scale_factor") * gravity(*evidence.plan.site), 10000.0, 1.0) << positions;
    for (const auto& finding : estimate.findings)
      EXPECT_NE(finding.severity, Finding::Severity::error) << finding.message;
  }
}

TEST(AccelerometerTumble, PositionsTooFewAreRefused) {
  EXPECT_NE(refusal(method(), evidence_of({{0, 0}, {180, 0}}, unit)).find("with it up and down"), std::string::npos);
}

}  // namespace
}  // namespace tumble::accelerometer_tumble_test
