#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "tumble/math/random.hpp"
#include "tumble/models/testing/truth.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using namespace testing;

const Model& model() { return find_model("dynamically_tuned_gyro"); }

TEST(DynamicallyTunedGyro, HarmonicsOfTheRotatingForceAreThoseOfTheReference) {
  // docs/equations (1.2): f_X = -a cos th, f_Y = -a sin th, f_Z = 1 g; docs/equations (1.9)-(1.11) over one whole turn
  const auto truth = truth_of(model(), {{"D_x", "6 deg/h/g"},
                                        {"D_y", "-2.5 deg/h/g"},
                                        {"D_xz", "0.15 deg/h/g^2"},
                                        {"D_yz", "-0.05 deg/h/g^2"},
                                        {"D_xxx", "8e-4 deg/h/g^3"}});
  struct Row {
    double arm_rate, a, A, B, K, zeta;  ///< [deg/s], [g], [deg/h], [deg/h], [deg/h/g], [%]
  };
  // synthetic reference table, R = 2.5 m, g0 = 9.80665 m/s^2
  const Row rows[] = {{114.0, 1.009, -6.2073, 2.5735, 6.65827, 0.0},
                      {160.0, 1.988, -12.2308, 5.0694, 6.65989, 0.024},
                      {254.0, 5.010, -30.8872, 12.776, 6.67162, 0.200},
                      {359.0, 10.008, -62.153, 25.521, 6.71328, 0.826},
                      {508.0, 20.040, -128.076, 51.102, 6.88091, 3.344}};
  const double g = si(1.0, "g");
  double first = 0.0;
  for (const auto& row : rows) {
    const double a = std::pow(si(row.arm_rate, "deg/s"), 2) * 2.5 / g;
    std::complex<double> sum;
    const int n = 64;
    for (int j = 0; j < n; ++j) {
      const double angle = 2.0 * std::numbers::pi * j / n;
      Felt felt;
      felt.specific_force = {-a * g * std::cos(angle), -a * g * std::sin(angle), g};
      sum += 2.0 / n * Unit::parse("deg/h").from_si(indicated(model(), truth, felt)) * std::polar(1.0, angle);
    }
    const double K = std::abs(sum) / a;
    if (first == 0.0) first = K;
    // half of the last printed digit, and the reference's record of 900 s at 10 ms: up to half a sample beyond whole
    // turns, which takes the same part of the amplitude
    const double cut = 0.005 / 900.0;
    EXPECT_NEAR(a, row.a, 5.1e-4) << row.arm_rate;
    EXPECT_NEAR(K, row.K, 5.1e-6 + cut * K) << row.arm_rate;
    EXPECT_NEAR(100.0 * (K / first - 1.0), row.zeta, 5.1e-4 + 100.0 * cut) << row.arm_rate;
    EXPECT_NEAR(sum.real(), row.A, 5.1e-4 + cut * K * a) << row.arm_rate;
    EXPECT_NEAR(sum.imag(), row.B, 5.1e-4 + cut * K * a) << row.arm_rate;
  }
}

TEST(DynamicallyTunedGyro, PhysicsIsTheTorqueOnTheCapturedRotor) {
  // delta x H z = -M: e_X = M_Y/H, e_Y = -M_X/H
  const double m = 0.05, H = 0.02, l_Z = 4e-9, C_a = 6e-9, C_r = 2e-9, q = 3e-10;
  const auto truth = truth_of(model(), {{"angular_momentum", "0.02 kg*m^2/s"},
                                        {"mass", "0.05 kg"},
                                        {"mass_offset_Z", "4 nm"},
                                        {"axial_compliance", "6e-9 m/N"},
                                        {"radial_compliance", "2e-9 m/N"},
                                        {"quadrature_torque", "3e-10 N*m/(m/s^2)"},
                                        {"torque_X", "1e-9 N*m"},
                                        {"torque_Y", "-2e-9 N*m"}});
  const RandomStream random(4);
  for (std::uint64_t n = 0; n < 20; ++n) {
    const Vector3 f{100.0 * random.normal(3 * n), 100.0 * random.normal(3 * n + 1), 100.0 * random.normal(3 * n + 2)};
    const Vector3 centre = Vector3{0.0, 0.0, l_Z} - m * Vector3{C_r * f.x, C_r * f.y, C_a * f.z};
    const Vector3 torque = cross(centre, -m * f) + Vector3{q * f.x + 1e-9, q * f.y - 2e-9, 0.0};
    Felt felt;
    felt.specific_force = f;
    EXPECT_NEAR(indicated(model(), truth, felt, 0), torque.y / H, 1e-14 * norm(torque) / H + 1e-18);
    EXPECT_NEAR(indicated(model(), truth, felt, 1), -torque.x / H, 1e-14 * norm(torque) / H + 1e-18);
  }
}

TEST(DynamicallyTunedGyro, MisalignmentsAndScaleFactorsAreThoseOfTheirAxis) {
  const auto truth = truth_of(model(), {{"scale_factor_error", "1000 ppm"},
                                        {"gamma_y", "1 mrad"},
                                        {"gamma_z", "2 mrad"},
                                        {"y_scale_factor_error", "-500 ppm"},
                                        {"y_gamma_x", "3 mrad"},
                                        {"y_gamma_z", "4 mrad"}});
  Felt felt;
  felt.rate = {1.0, 10.0, 100.0};
  EXPECT_NEAR(indicated(model(), truth, felt, 0), 1.001 + 0.01 + 0.2, 1e-14);
  EXPECT_NEAR(indicated(model(), truth, felt, 1), 9.995 + 0.003 + 0.4, 1e-14);
}

TEST(DynamicallyTunedGyro, CaptureLoopOfEitherOrder) {
  for (const auto& [truth, lag] :
       {std::pair{truth_of(model(), {{"time_constant", "2 ms"}}), 2e-3},
        std::pair{truth_of(model(), {{"natural_frequency", "50 Hz"}, {"damping_ratio", "0.5"}}),
                  1.0 / (100.0 * std::numbers::pi)}})
    for (const std::size_t output : {0, 1}) {
      std::vector<double> ramp(3000);
      for (std::size_t n = 0; n < ramp.size(); ++n) ramp[n] = 1e-3 * static_cast<double>(n);
      model().record(truth, output, 1e-3, RandomStream(1)).response(ramp);
      EXPECT_NEAR(ramp.back(), 2.999 - lag, 1e-12);
    }
  const auto both = truth_of(model(), {{"time_constant", "2 ms"}, {"natural_frequency", "50 Hz"}});
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "natural_frequency (second-order), not both"},
                      [&] { model().record(both, 0, 1e-3, RandomStream(1)); }));
  EXPECT_FALSE(model().record(truth_of(model(), {}), 0, 1e-3, RandomStream(1)).response);
}

TEST(DynamicallyTunedGyro, ListsAllThatTheElectronicsCannotDo) {
  Problems problems;
  resolve(truth_options(model()),
          {{"natural_frequency", "-1 Hz", "test"},
           {"damping_ratio", "0", "test"},
           {"range_negative", "0 deg/s", "test"},
           {"resolution", "-1 deg/h", "test"},
           {"dead_zone", "-1 deg/h", "test"}},
          "model", problems);
  EXPECT_EQ(problems.size(), 5u);
  const auto truth =
      truth_of(model(), {{"natural_frequency", "50 Hz"}, {"time_constant", "2 ms"}, {"range_negative", "1 deg/s"}});
  try {
    model().record(truth, 0, 0.01, RandomStream(1));
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_input);
    EXPECT_EQ(error.problems.size(), 2u) << error.what();
  }
}

TEST(DynamicallyTunedGyro, ListsAllThatThePhysicsLacks) {
  const auto truth = truth_of(model(), {{"mass_offset_Z", "4 nm"}});
  try {
    model().coefficients(truth);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.problems.size(), 2u) << error.what();
  }
}

}  // namespace
}  // namespace tumble
