#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/testing/asserts.hpp"
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

// A thermometer that shows 3 K too little at all temperatures: every polynomial is one of another temperature.
TEST(FourPositionSetPoints, AnOffsetOfTheThermometerIsNamedAndInTheUncertainty) {
  const Method& method = find_method("accelerometer_four_position");
  for (const double offset : {-3.0, -1.0, 3.0}) {
    Trial trial = trial_of(method, 1);
    for (Channel& channel : trial.evidence.recordings.front().channels)
      if (channel.kind == QuantityKind::temperature)
        for (double& value : channel.values) value += offset;
    const Estimate estimate = method.identify(trial.evidence, {});
    EXPECT_EQ(has_finding(estimate.findings, "temperature_off_set_point"), std::abs(offset) > 2.5) << offset;
    for (const auto& [name, truth] : trial.truth) {
      const auto i = static_cast<std::size_t>(find_parameter(estimate, name) - estimate.parameters.data());
      EXPECT_LT(std::abs(estimate.parameters[i].value - truth), 2.5 * standard_uncertainty(estimate, i)) << name;
    }
  }
}

// A unit that heats itself by 8 K is as sound as another, where the plan says it.
TEST(FourPositionSetPoints, AUnitThatHeatsItselfIsStated) {
  const Method& method = find_method("accelerometer_four_position");
  const auto warmer = [&](double stated) {
    Trial trial = trial_of(method, 1);
    for (Channel& channel : trial.evidence.recordings.front().channels)
      if (channel.kind == QuantityKind::temperature)
        for (double& value : channel.values) value += 8.0;
    trial.evidence.plan.settings.set_number("self_heating", stated, Unit::parse("K"));
    const Estimate estimate = method.identify(trial.evidence, {});
    EXPECT_EQ(has_finding(estimate.findings, "temperature_off_set_point"), stated == 0.0);
    return standard_uncertainty(estimate, 0);
  };
  EXPECT_GT(warmer(0.0), 10.0 * warmer(8.0));
}

}  // namespace
}  // namespace tumble::set_points_test
