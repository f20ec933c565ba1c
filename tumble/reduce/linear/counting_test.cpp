#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::linear {
namespace {

constexpr double per_g = 200.0;  // pulse/s/g: a pulse in 60 s is 83 ug

/// Twelve positions of a minute on an ideal head, counted at 10 Hz.
Plan plan_of(double random_walk) {
  Plan plan = trial_plan("accelerometer_dynamic", {}, "pendulous_accelerometer", "dividing_head", 10.0);
  plan.rig.set_flag("ideal", true);
  plan.truth.set_word("output", "count");
  set_truth(plan, "pulse_scale_factor", per_g, "pulse/s/g");
  set_truth(plan, "bias", 3.0, "mg");
  set_truth(plan, "angle_random_walk", random_walk, "ug/sqrt(Hz)");
  for (int k = 0; k < 12; ++k) {
    const Motion head{.kind = Motion::Kind::hold, .value = si(30.0 * k + 3.7, "deg")};
    plan.schedule.push_back({"position " + std::to_string(k), 60.0, 1, {{"head", head}}});
  }
  return plan;
}

Problem problem_of() {
  Problem problem;
  problem.role = "accelerometer";
  problem.input = [](const Felt& felt) { return felt.specific_force.x; };
  problem.scale = 10.0 / si(per_g, "pulse/s/g");
  problem.pulse = 1.0 / si(per_g, "pulse/s/g");
  problem.columns = terms_of("pendulous_accelerometer", defaults(find_model("pendulous_accelerometer").constants()),
                             {"bias", "scale_factor_error"});
  return problem;
}

struct Scatter {
  double rms_deviation = 0.0;  ///< of the bias, in standard uncertainties
  double mean_sd = 0.0;
  double white = 0.0;  ///< mean white noise over the true one
};

constexpr int seeds = 200;

Scatter scatter(double random_walk, const Problem& problem) {
  const Plan plan = plan_of(random_walk);
  const double density = plan.truth.number("angle_random_walk");
  Scatter scatter;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Solution found = identify({plan, {simulate(plan, static_cast<std::uint64_t>(seed), {})}}, problem);
    const double sd = std::sqrt(found.fit.covariance(0, 0));
    scatter.rms_deviation += std::pow((found.fit.parameters[0] - plan.truth.number("bias")) / sd, 2) / seeds;
    scatter.mean_sd += sd / seeds;
    scatter.white += found.fit.white_variance / (density * density) / seeds;
  }
  scatter.rms_deviation = std::sqrt(scatter.rms_deviation);
  return scatter;
}

// 10 ug/sqrt(Hz) leave 1.3 ug on a minute, rounding 83/sqrt(6) = 34 ug; 1 mg/sqrt(Hz) leaves 129 ug. The rms of 200
// deviations is known to 1/20: below 1.2 the intervals hold. They may be too wide, by half where rounding prevails: a
// noise that hides in it can only be bounded, and a constant input makes rounding a line of its own in the spectrum.
TEST(CountingMethodsCoverage, StandardUncertaintiesHoldWhetherRoundingOrNoisePrevails) {
  for (const double random_walk : {10.0, 1000.0}) {
    const Scatter found = scatter(random_walk, problem_of());
    EXPECT_LT(found.rms_deviation, 1.2) << random_walk;
    EXPECT_GT(found.rms_deviation, 0.6) << random_walk;
  }
}

TEST(CountingMethods, RoundingIsNotMistakenForWhiteNoise) {
  const double least = si(83.3, "ug") / std::sqrt(6.0 * 12.0);  // of the mean of twelve positions
  Problem blind = problem_of();
  blind.pulse = 0.0;
  const double seen = scatter(10.0, problem_of()).mean_sd, without = scatter(10.0, blind).mean_sd;
  EXPECT_GT(seen, least);
  EXPECT_LT(seen, 1.7 * least);
  EXPECT_GT(without, 3.0 * least);
  EXPECT_NEAR(scatter(1000.0, problem_of()).white, 1.0, 0.15);
}

TEST(CountingMethods, APredictionHasTheSameLine) {
  const Plan plan = plan_of(10.0);
  const Solution found = predict(plan, problem_of(), truth_of(plan, "accelerometer"));
  const Estimate estimate = estimate_of(found);
  const auto line = std::ranges::find(estimate.budget, "counting", &Contribution::source);
  ASSERT_NE(line, estimate.budget.end());
  // 1/sqrt(6) pulse in 55 to 60 s, what slewing leaves of a minute, twelve of them: the bias is nearly their mean
  const double expected = 1.0 / std::sqrt(6.0) / 60.0 / si(per_g, "pulse/s/g") / std::sqrt(12.0);
  EXPECT_GT(std::sqrt(line->variance(0)), expected);
  EXPECT_LT(std::sqrt(line->variance(0)), 60.0 / 55.0 * expected);
}

}  // namespace
}  // namespace tumble::linear
