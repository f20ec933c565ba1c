#include "tumble/exchange/decision.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
using Outcome = Decision::Outcome;

/// Production of which 95 % lie within limits of -1 and 1.
Population population() { return {0.0, 1.0 / 1.959963984540054}; }

/// Table of global risks: quadrature of two authors, printed to 1e-6; hence half a unit of the last digit.
struct Row {
  double ratio, simple, guarded, method6;
};

TEST(GlobalRisk, AgreesWithPublishedFigures) {
  for (const Row& row : {Row{4.0, 0.008583, 0.000208, 0.007563}, Row{2.0, 0.013373, 0.000359, 0.006537}}) {
    const double sd = 1.0 / (2.0 * row.ratio);  // of an expanded uncertainty with k = 2
    const auto consumer = [&](double guard) {
      return global_risk(population(), sd, {-1.0, 1.0}, {-1.0 + guard, 1.0 - guard}).consumer;
    };
    EXPECT_NEAR(consumer(0.0), row.simple, 0.6e-6);
    EXPECT_NEAR(consumer(2.0 * sd), row.guarded, 0.6e-6);
    EXPECT_NEAR(consumer(2.0 * sd * method6_guard_band(row.ratio)), row.method6, 0.6e-6);
  }
}

TEST(GlobalRisk, OfAMillionSimulatedInstruments) {
  std::mt19937_64 random(20260401);
  std::normal_distribution<double> normal;
  const double sd = 0.2, count = 1e6;
  const Tolerance tolerance{-1.0, 1.0}, acceptance{-0.8, 0.9};
  double consumer = 0.0, producer = 0.0;
  for (int i = 0; i < 1'000'000; ++i) {
    const double truth = 0.1 + 0.5 * normal(random), measured = truth + sd * normal(random);
    if (acceptance.holds(measured) && !tolerance.holds(truth)) ++consumer;
    if (!acceptance.holds(measured) && tolerance.holds(truth)) ++producer;
  }
  const GlobalRisk risk = global_risk({0.1, 0.5}, sd, tolerance, acceptance);
  EXPECT_NEAR(consumer / count, risk.consumer, 4.0 * std::sqrt(risk.consumer / count));
  EXPECT_NEAR(producer / count, risk.producer, 4.0 * std::sqrt(risk.producer / count));
}

TEST(GlobalRisk, OfOneLimitIsTheBivariateNormal) {
  // Accepted below 0 and out of tolerance above 0: the quarter plane of correlation rho = sigma/sqrt(sigma^2 + u^2)
  // has the probability 1/4 - asin(rho)/(2 pi).
  const double rho = 1.0 / std::sqrt(1.0 + 0.09);
  const GlobalRisk risk = global_risk({0.0, 1.0}, 0.3, {-inf, 0.0}, {-inf, 0.0});
  EXPECT_NEAR(risk.consumer, 0.25 - std::asin(rho) / (2.0 * std::acos(-1.0)), 1e-10);
  EXPECT_NEAR(risk.producer, risk.consumer, 1e-10);
}

TEST(GlobalRisk, OfAnAlmostPerfectMeasurementVanishes) {
  const GlobalRisk risk = global_risk(population(), 1e-9, {-1.0, 1.0}, {-1.0, 1.0});
  EXPECT_LT(risk.consumer, 1e-8);
  EXPECT_LT(risk.producer, 1e-8);
  EXPECT_NEAR(global_risk(population(), 1e-9, {-1.0, 1.0}, {inf, -inf}).producer, 0.95, 1e-9);
}

TEST(GlobalRisk, TheGuardBandOfTheFleetKeepsTheTarget) {
  // acceptance limits for 2 %, 0.5 % and 0.1 % of a known production, printed to 1e-3
  struct Fleet {
    double ratio, limits[3];
  };
  const std::vector<Population> known{population()};
  for (const Fleet& fleet :
       {Fleet{4.0, {1.118, 0.948, 0.833}}, Fleet{2.0, {1.105, 0.815, 0.605}}, Fleet{1.0, {1.055, 0.520, 0.164}}})
    for (int k = 0; k < 3; ++k) {
      const double target[]{0.02, 0.005, 0.001}, sd = 1.0 / (2.0 * fleet.ratio);
      const auto limits = acceptance_of_fleet(known, sd, {-1.0, 1.0}, target[k]);
      EXPECT_NEAR(limits.upper, fleet.limits[k], 0.6e-3) << fleet.ratio;
      EXPECT_NEAR(global_risk(known, sd, {-1.0, 1.0}, limits).consumer, target[k], 1e-7);
    }
  EXPECT_EQ(acceptance_of_fleet(known, 0.1, {-1.0, 1.0}, 0.06).upper, inf) << "only 5 % are out of tolerance";
  EXPECT_NEAR(acceptance_of_fleet(known, 0.1, {-inf, 1.0}, 0.001).upper, 0.86, 0.1);
}

TEST(GlobalRisk, OfAProductionThatIsNotKnownIsTheMeanOfWhatItMayBe) {
  const std::vector<Population> either{population(), {0.2, 0.7}, {0.9, 0.0}};
  const Tolerance limits{-1.0, 1.0};
  double consumer = 0.0, producer = 0.0;
  for (const Population& one : either) {
    consumer += global_risk(one, 0.2, limits, limits).consumer / 3.0;
    producer += global_risk(one, 0.2, limits, limits).producer / 3.0;
  }
  EXPECT_NEAR(global_risk(either, 0.2, limits, limits).consumer, consumer, 1e-15);
  EXPECT_NEAR(global_risk(either, 0.2, limits, limits).producer, producer, 1e-15);
  EXPECT_NEAR(global_risk(Population{0.9, 0.0}, 0.2, limits, limits).producer, 0.308538, 1e-6);
  EXPECT_NEAR(global_risk(Population{1.1, 0.0}, 0.2, limits, limits).consumer, 0.308538, 1e-6);
}

TEST(SpecificRisk, IsHalfAtALimit) {
  EXPECT_DOUBLE_EQ(specific_risk({1.0, 0.1}, {-inf, 1.0}), 0.5);
  EXPECT_NEAR(specific_risk({1.0, 0.1}, {-1.0, 1.0}), 0.5, 1e-15);
  EXPECT_EQ(specific_risk({1.0, 0.1}, {}), 0.0);
}

TEST(SpecificRisk, TakesStudentsT) {
  // t_0.975 of 5 degrees of freedom is 2.570582 (GUM, table G.2: 2.57).
  EXPECT_NEAR(specific_risk({0.0, 1.0, 5.0}, {-inf, 2.5705818356363}), 0.025, 1e-9);
  EXPECT_NEAR(specific_risk({0.0, 1.0}, {-inf, 1.959963984540054}), 0.025, 1e-12);
}

TEST(SpecificRisk, KeepsItsDigitsWhereItIsSmall) {
  EXPECT_NEAR(specific_risk({0.0, 1.0}, {-inf, 10.0}) / 7.619853024160527e-24, 1.0, 1e-12);
}

TEST(SpecificRisk, OfAnIntervalThatIsNotSymmetricHasItsEndsAtTwoAndAHalfPerCent) {
  const Measured measured{1.0, 0.3, 4.0, 0.6, 2.9};
  EXPECT_NEAR(specific_risk(measured, {-inf, 2.9}), 0.025, 1e-12);
  EXPECT_NEAR(specific_risk(measured, {0.6, inf}), 0.025, 1e-12);
  EXPECT_NEAR(specific_risk(measured, {-inf, 1.0}), 0.5, 1e-12);
}

TEST(Rule, GuardBandsOfOneUncertaintyKeepTheRiskBelowTwoAndAHalfPerCent) {
  // ILAC-G8, table 1: w = U below 2.5 %, 1.5 U below 0.16 %.
  for (const auto& [r, most] : {std::pair{1.0, 0.0250001}, {1.5, 0.0017}, {0.0, 0.5000001}}) {
    const DecisionRule rule{DecisionRule::Kind::guarded, r};
    const Tolerance at = acceptance_of({0.0, 0.1}, {-inf, 1.0}, rule);
    EXPECT_LE(specific_risk({at.upper, 0.1}, {-inf, 1.0}), most);
  }
}

TEST(Rule, OfSpecificRiskAcceptsUpToTheRisk) {
  const DecisionRule rule{DecisionRule::Kind::risk, 0.05};
  EXPECT_NEAR(acceptance_of({0.0, 0.1}, {-inf, 1.0}, rule).upper, 1.0 - 0.16448536269514722, 1e-12);
  const Tolerance both = acceptance_of({0.0, 0.4}, {-1.0, 1.0}, rule);
  EXPECT_NEAR(specific_risk({both.upper, 0.4}, {-1.0, 1.0}), 0.05, 1e-12);
  EXPECT_NEAR(both.lower, -both.upper, 1e-12);
  EXPECT_TRUE(acceptance_of({0.0, 0.6}, {-1.0, 1.0}, rule).empty());
  EXPECT_EQ(decide({0.0, 0.6}, {-1.0, 1.0}, rule).outcome, Outcome::undecided);
}

TEST(Rule, Method6IsOffAboveARatioOfFourAndAHalf) {
  EXPECT_EQ(method6_guard_band(4.7), 0.0);
  EXPECT_NEAR(method6_guard_band(2.0), 1.04 - std::exp(0.38 * std::log(2.0) - 0.54), 1e-15);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "method6"}, [&] {
    decide({0.0, 0.1}, {-inf, 1.0}, {DecisionRule::Kind::method6});
  }));
}

TEST(Rule, NonBinaryHasFourStatements) {
  const DecisionRule rule = parse_decision_rule("non-binary");
  const auto outcome = [&](double value) { return decide({value, 0.1}, {-inf, 1.0}, rule).outcome; };
  EXPECT_EQ(outcome(0.80), Outcome::pass);
  EXPECT_EQ(outcome(0.81), Outcome::conditional_pass);
  EXPECT_EQ(outcome(1.19), Outcome::conditional_fail);
  EXPECT_EQ(outcome(1.20), Outcome::fail);
}

TEST(Rule, OutcomesAreMonotoneTowardsALimit) {
  for (const char* text : {"simple", "guarded:0.83", "guarded:-1", "risk:0.025", "method6", "non-binary"})
    for (const Measured& start : {Measured{0.0, 0.2}, {0.0, 0.2, 3.0}, {0.0, 0.2, 3.0, -0.3, 0.7}}) {
      auto before = Outcome::pass;
      for (double shift = 0.0; shift < 3.0; shift += 0.01) {
        Measured at = start;
        at.value += shift, at.lower += shift, at.upper += shift;
        const auto now = decide(at, {-1.5, 1.5}, parse_decision_rule(text)).outcome;
        EXPECT_GE(now, before) << text << " at " << shift;
        before = now;
      }
      EXPECT_EQ(before, Outcome::fail) << text;
    }
}

TEST(Rule, IsReadAsItIsWritten) {
  for (const char* text : {"simple", "guarded:0.83", "guarded:1", "risk:0.025", "method6", "non-binary"})
    EXPECT_EQ(name(parse_decision_rule(text)), text);
  EXPECT_EQ(name(parse_decision_rule("guarded")), "guarded:1");
  for (const char* text :
       {"", "Simple", "guarded:", "guarded:x", "guarded:9", "risk", "risk:0", "risk:0.6", "simple:1"})
    EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {text}}, [&] { parse_decision_rule(text); })) << text;
}

TEST(Posterior, LiesBetweenProductionAndMeasurement) {
  const Measured together = posterior({1.0, 0.3}, {0.0, 0.4});
  EXPECT_NEAR(together.value, 0.16 / (0.16 + 0.09), 1e-15);
  EXPECT_NEAR(together.sd, 0.3 * 0.4 / 0.5, 1e-15);
}

Matrix correlation_of(std::size_t n, double rho) {
  Matrix matrix(n, n, rho);
  for (std::size_t i = 0; i < n; ++i) matrix(i, i) = 1.0;
  return matrix;
}

TEST(JointConformance, OfIndependentParametersIsTheProduct) {
  const std::vector<Measured> measured{{0.5, 0.4}, {0.0, 1.0, 4.0}, {2.0, 1.0}};
  const std::vector<Tolerance> tolerances{{-1.0, 1.0}, {-inf, 1.0}, {0.0, inf}};
  double product = 1.0;
  for (std::size_t i = 0; i < 3; ++i) product *= 1.0 - specific_risk(measured[i], tolerances[i]);
  EXPECT_NEAR(joint_conformance(measured, tolerances, correlation_of(3, 0.0)), product, 1e-12);
}

TEST(JointConformance, OfThreeOrthantsHasItsClosedForm) {
  // P(all below 0) = 1/8 + (asin r12 + asin r13 + asin r23)/(4 pi)
  const double rho = 0.6;
  const std::vector<Measured> measured(3, {0.0, 1.0});
  const std::vector<Tolerance> tolerances(3, {-inf, 0.0});
  EXPECT_NEAR(joint_conformance(measured, tolerances, correlation_of(3, rho)),
              0.125 + 3.0 * std::asin(rho) / (4.0 * std::acos(-1.0)), 1e-4);
}

TEST(JointConformance, OfOneParameterTwiceIsThatOfOne) {
  const std::vector<Measured> measured(2, {0.5, 0.4});
  const std::vector<Tolerance> tolerances(2, {-1.0, 1.0});
  EXPECT_NEAR(joint_conformance(measured, tolerances, correlation_of(2, 1.0)),
              1.0 - specific_risk(measured[0], tolerances[0]), 1e-9);
}

TEST(JointConformance, OfTwentyAlikeIsAnIntegralOverOne) {
  // Correlation 0.5 of all: given the common part z each is independent, P = E Phi(sqrt(2) a + z)^20.
  const double a = 2.0;
  double expected = 0.0;
  for (double z = -8.0; z <= 8.0; z += 1e-3)
    expected += 1e-3 * std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::acos(-1.0)) *
                std::pow(0.5 * std::erfc(-(std::sqrt(2.0) * a - z) / std::sqrt(2.0)), 20);
  EXPECT_NEAR(joint_conformance(std::vector<Measured>(20, {0.0, 1.0}), std::vector<Tolerance>(20, {-inf, a}),
                                correlation_of(20, 0.5)),
              expected, 2e-4);
}

}  // namespace
}  // namespace tumble
