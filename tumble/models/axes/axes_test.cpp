#include "tumble/models/axes/axes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// Coefficient times regressor of one term of an output.
double shown(const Output& output, const std::string& term, const Felt& felt) {
  for (const auto& one : output.terms)
    if (one.name == term) return one.regressor(felt);
  ADD_FAILURE() << "no term " << term;
  return 0.0;
}

TEST(Axes, LeverArmIsTheSecondDerivativeOfAPointOnATurningBody) {
  // A body turns about a fixed axis n by p(t); the point r has the acceleration p'' n x r + p'^2 n x (n x r).
  const Vector3 n = (1.0 / 3.0) * Vector3{1.0, 2.0, 2.0}, r{0.03, -0.01, 0.02};
  const double speed = 2.0, acceleration = -5.0;
  Felt felt;
  felt.rate = speed * n;
  felt.angular_acceleration = acceleration * n;
  const Vector3 expected = acceleration * cross(n, r) + speed * speed * cross(n, cross(n, r));
  const auto outputs = axes::accelerometers();
  const double all[3]{expected.x, expected.y, expected.z};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& output = outputs[i];
    const double got = r.x * shown(output, output.channel + "_lever_x", felt) +
                       r.y * shown(output, output.channel + "_lever_y", felt) +
                       r.z * shown(output, output.channel + "_lever_z", felt);
    EXPECT_NEAR(got, all[i], 1e-15);
  }
}

TEST(Axes, EveryAxisSeesItsOwnComponentAndLeansTowardTheOthers) {
  Felt felt;
  felt.rate = {1.0, 2.0, 3.0};
  felt.specific_force = {-4.0, 5.0, 6.0};
  const auto gyros = axes::gyros(), accelerometers = axes::accelerometers();
  EXPECT_EQ(gyros[2].input(felt), 3.0);
  EXPECT_EQ(accelerometers[0].input(felt), -4.0);
  EXPECT_EQ(shown(gyros[2], "gyro_z_misalignment_y", felt), 2.0);
  EXPECT_EQ(shown(gyros[0], "gyro_x_acceleration_sensitivity_z", felt), 6.0);
  EXPECT_EQ(shown(accelerometers[0], "accelerometer_x_second_order_coefficient", felt), 16.0);
  EXPECT_EQ(shown(accelerometers[1], "accelerometer_y_misalignment_x", felt), -4.0);
}

TEST(Axes, IncrementsAreWhatIsGainedInAStep) {
  auto truth = defaults(truth_options(find_model("imu")));
  truth.set_word("output", "increments");
  const Recorded recorded = axes::record(axes::gyros()[0], truth, 0.01, RandomStream(1));
  EXPECT_EQ(recorded.kind, QuantityKind::angle);
  EXPECT_TRUE(recorded.accumulates);
  std::vector<double> samples(3, 2.0);
  recorded.response(samples);
  EXPECT_DOUBLE_EQ(samples[2], 0.02);
}

TEST(Axes, CountsAddUpToTheIntegralWithinAPulse) {
  auto truth = defaults(truth_options(find_model("imu")));
  truth.set_word("gyro_output", "count");
  truth.set_number("gyro_pulse_scale_factor", si(0.5, "pulse/arcsec"), Unit::parse("pulse/arcsec"));
  const Recorded recorded = axes::record(axes::gyros()[0], truth, 0.01, RandomStream(1));
  EXPECT_EQ(recorded.kind, QuantityKind::count);
  EXPECT_TRUE(recorded.accumulates);
  std::vector<double> samples(1000, si(7.3, "deg/h"));  // 7.3 arcsec/s for 10 s: 36.5 pulses
  recorded.response(samples);
  double total = 0.0;
  for (const double n : samples) {
    EXPECT_EQ(n, std::round(n));
    total += n;
  }
  EXPECT_LT(std::abs(total - 36.5), 1.0);
}

TEST(Axes, CountsNeedThePulsesPerAngle) {
  auto truth = defaults(truth_options(find_model("imu")));
  truth.set_word("accelerometer_output", "count");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"accelerometer_pulse_scale_factor"}},
                      [&] { axes::record(axes::accelerometers()[0], truth, 0.01, RandomStream(1)); }));
}

TEST(Axes, ATriadAcceptsTheTermsOfEitherKind) {
  std::size_t gyro = 0, accelerometer = 0;
  for (const auto& option : truth_options(find_model("triad"))) {
    gyro += option.name == "gyro_x_bias";
    accelerometer += option.name == "accelerometer_x_bias";
  }
  EXPECT_EQ(gyro, 1u);
  EXPECT_EQ(accelerometer, 1u);
}

}  // namespace
}  // namespace tumble
