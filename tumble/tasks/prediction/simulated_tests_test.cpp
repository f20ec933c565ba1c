#include "tumble/tasks/prediction/simulated_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/core/budget.hpp"
#include "tumble/core/testing/asserts.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::prediction {
namespace {

Plan ready(const std::string& name, const Sets& sets = {}) {
  return load_plan(std::string(TUMBLE_SOURCE_DIR) + "/plans/" + name + ".toml", sets);
}

double sd_of(const Estimate& estimate, const std::string& name) {
  const auto* found = find_parameter(estimate, name);
  if (!found) return std::nan("");
  return standard_uncertainty(estimate, static_cast<std::size_t>(found - estimate.parameters.data())) /
         found->unit.factor();
}

// 100 tests of the plan scatter by 125 ppm and 13 arcsec; the table of terms predicted 420 000 ppm and 90 000 arcsec,
// since it takes the poses of the hand as the reference.
TEST(PredictionByTests, IsThatOfTheMethodAndNotOfTheTermsOfTheModel) {
  const auto estimate = predict(ready("imu_multi_position"));
  EXPECT_GT(sd_of(estimate, "gyro_x_scale_factor_error"), 0.8 * 125.0);
  EXPECT_LT(sd_of(estimate, "gyro_x_scale_factor_error"), 1.25 * 125.0);
  EXPECT_TRUE(has_finding(estimate.findings, "predicted_from_tests"));
}

TEST(PredictionByTests, IsTheSameEachTimeAndItsBudgetSumsToTheCovariance) {
  const auto plan = ready("static_bias");
  const auto one = predict(plan), other = predict(plan);
  ASSERT_EQ(one.covariance.values, other.covariance.values);
  const Matrix sum = covariance_of(one.budget, one.parameters.size());
  for (std::size_t i = 0; i < one.parameters.size(); ++i)
    EXPECT_NEAR(sum(i, i) / one.covariance(i, i), 1.0, 1e-9) << one.parameters[i].name;
}

TEST(PredictionByTests, SaysBeforeTheTestWhatTheMethodWouldRefuse) {
  auto plan = ready("imu_ferraris");
  plan.schedule.resize(4);  // poses are missing, and all turns
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "would refuse this test"}, [&] { predict(plan); }));
}

// 30 times the instability cannot leave the prediction as it is.
TEST(PredictionOfFourPositions, ContainsSlowNoise) {
  const auto little = predict(ready("accelerometer_four_position", {{"truth.bias_instability", "2 ug"}}));
  const auto much = predict(ready("accelerometer_four_position", {{"truth.bias_instability", "60 ug"}}));
  EXPECT_GT(sd_of(much, "b_1"), 5.0 * sd_of(little, "b_1"));
}

}  // namespace
}  // namespace tumble::prediction
