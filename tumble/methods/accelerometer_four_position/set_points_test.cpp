#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"

namespace tumble::set_points_test {
namespace {

// A thermometer that shows 1 % too much, in degC: the coefficients over temperature are off by 1 and 2 %, and nothing but the
// set points says so.
TEST(FourPositionSetPoints, AnotherScaleOfTheThermometerIsInTheUncertainty) {
  const Method& method = find_method("accelerometer_four_position");
  Trial trial = trial_of(method, 1);
  const Estimate sound = method.identify(trial.evidence, {});
  for (Channel& channel : trial.evidence.recordings.front().channels)
    if (channel.kind == QuantityKind::temperature)
      for (double& value : channel.values) value += 0.01 * (value - 273.15);
  const Estimate estimate = method.identify(trial.evidence, {});
  const auto line_of = [](const Estimate& of) {
    return std::ranges::find(of.budget, "thermometer against the set points", &Contribution::source);
  };
  ASSERT_NE(line_of(estimate), estimate.budget.end());
  for (const char* name : {"c_1", "c_2"}) {
    const auto i = static_cast<std::size_t>(find_parameter(estimate, name) - estimate.parameters.data());
    const double truth = std::ranges::find(trial.truth, name, &std::pair<std::string, double>::first)->second;
    EXPECT_LT(std::abs(estimate.parameters[i].value - truth), 2.0 * standard_uncertainty(estimate, i)) << name;
    EXPECT_GT(standard_uncertainty(estimate, i), 3.0 * standard_uncertainty(sound, i)) << name;
    const double in_sound = line_of(sound) == sound.budget.end() ? 0.0 : line_of(sound)->variance(i);
    EXPECT_LT(std::sqrt(in_sound), 0.3 * standard_uncertainty(sound, i)) << name;
  }
}

}  // namespace
}  // namespace tumble::set_points_test
