// The model against the equations of motion of the gimbal, integrated in full, and against the numbers of the lecture.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tumble/math/random.hpp"
#include "tumble/math/rotation.hpp"
#include "tumble/models/testing/oscillator.hpp"
#include "tumble/models/testing/truth.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::sdof_gyro_test {
namespace {

using namespace testing;

const Model& model() { return find_model("sdof_gyro"); }

using Written = std::vector<std::pair<std::string, std::string>>;

/// Gimbal of docs/equations (4.7)-(4.8), axes I, O, S as x, y, z.
struct Gimbal {
  double H = 0.0377, k = 20.0, D = 0.04;
  double I_I = 3e-5, I_O = 4e-5, I_S = 4e-5;
  double I_IO = 3e-9, I_OS = -4e-9, I_IS = 5e-9;

  /// beta'' while the case turns at w with acceleration w_dot [rad/s, rad/s^2 in case axes]: second component of
  /// dH/dt + w_iG x H = M with the gimbal turned by beta about O; nothing is left out.
  double acceleration(Swing beta, Vector3 w, Vector3 w_dot) const {
    const Rotation gimbal_from_case = about_y(beta.angle);
    const Vector3 carried = gimbal_from_case * w, relative{0.0, beta.rate, 0.0};
    const Vector3 W = carried + relative;
    const Vector3 W_dot = gimbal_from_case * w_dot - cross(relative, carried);  // without beta''
    const Vector3 momentum = {I_I * W.x - I_IO * W.y - I_IS * W.z, 0.0, -I_IS * W.x - I_OS * W.y + I_S * W.z + H};
    const double gyroscopic = W.z * momentum.x - W.x * momentum.z;
    const double torque = -D * beta.rate - k * beta.angle;
    return (torque - gyroscopic + I_IO * W_dot.x + I_OS * W_dot.z) / I_O - W_dot.y;
  }

  /// What the torquer shows [rad/s] once the loop has settled on these rates and accelerations.
  double steady(Vector3 w, Vector3 w_dot) const {
    Swing beta;
    const double step = 1e-4;  // w_n = 707 rad/s: 0.05 s are 25 time constants
    for (int n = 0; n < 500; ++n)
      beta = runge_kutta(beta, 0.0, step, [&](double, Swing b) { return acceleration(b, w, w_dot); });
    return k * beta.angle / H;
  }
};

/// The same gimbal as a plan writes it.
Settings truth_of_gimbal(const Written& more = {}) {
  Written written{{"angular_momentum", "0.0377 kg*m^2/s"},
                  {"loop_stiffness", "20 N*m/rad"},
                  {"gimbal_inertia_I", "3e-5 kg*m^2"},
                  {"gimbal_inertia_O", "4e-5 kg*m^2"},
                  {"gimbal_inertia_S", "4e-5 kg*m^2"},
                  {"gimbal_product_IO", "3e-9 kg*m^2"},
                  {"gimbal_product_OS", "-4e-9 kg*m^2"},
                  {"gimbal_product_IS", "5e-9 kg*m^2"},
                  {"damping", "0.04 N*m*s/rad"}};
  written.insert(written.end(), more.begin(), more.end());
  return truth_of(model(), written);
}

double rms_residual(const Settings& truth) {
  const Gimbal gimbal;
  double square = 0.0;
  const int cases = 100;
  for (int n = 0; n < cases; ++n) {
    Felt felt;
    felt.rate = any(RandomStream(1), n, 1.0);
    felt.angular_acceleration = any(RandomStream(2), n, 1.0);
    const double residual = gimbal.steady(felt.rate, felt.angular_acceleration) - indicated(model(), truth, felt);
    square += residual * residual / cases;
  }
  return std::sqrt(square);
}

TEST(SdofGyro, DynamicTermsAgreeWithTheFullEquationsToSecondOrderInTheLoopStiffness) {
  // left out, each uniform in +-1: (H/k)^3 w_I w_S^3 with rms 6.7e-9 * 0.22 = 1.5e-9, w_I^3 w_S the same,
  // (I_O/k)(H/k) w_O' w_S^2 with 3.8e-9 * 0.26 = 1e-9, products of inertia times the tilt (5e-9/H)(H/k) = 2.5e-10
  EXPECT_LT(rms_residual(truth_of_gimbal()), 3e-9);
}

TEST(SdofGyro, FirstOrderInTheLoopStiffnessIsHundredsOfTimesWorse) {
  // the lecture's K_III = (I_S - I_I)/k = -K_ISS lacks (H/k)^2 = 3.6e-6 s^2: some 6e-7 rad/s
  const auto lecture = truth_of_gimbal({{"K_III", "5e-7 s^2/rad^2"}, {"K_ISS", "-5e-7 s^2/rad^2"}});
  EXPECT_NEAR(rms_residual(lecture), 6e-7, 3e-7);
  // and half of the inertia part of K_ISS: 5e-7 times the rms of w_I w_S^2
  const double H_k = 0.0377 / 20.0;
  const auto half = truth_of_gimbal({{"K_ISS", fmt::format("{} s^2/rad^2", H_k * H_k - 5e-7)}});
  EXPECT_GT(rms_residual(half), 5e-8);
}

TEST(SdofGyro, AngularAccelerationAboutTheOutputAxisTiltsTheGimbal) {
  // (I_O/k) w_O' w_S: 2e-6 times the rms of two uniform factors, 1/3
  EXPECT_NEAR(rms_residual(truth_of_gimbal({{"tilt_coupling", "0 s^2/rad"}})), 2e-6 / 3.0, 0.2e-6);
}

TEST(SdofGyro, AnIntegratorTakesTheTiltTermsAway) {
  const auto truth = truth_of_gimbal({{"integrator", "true"}});
  const auto of = model().coefficients(truth);
  EXPECT_DOUBLE_EQ(of.at("K_IS"), 1e-5 / 0.0377);
  EXPECT_EQ(of.at("K_III"), 0.0);
  EXPECT_EQ(of.at("K_ISS"), 0.0);
}

TEST(SdofGyro, StaticTermsAreTheTorqueOfTheMassAboutTheOutputAxis) {
  const double m = 0.45, H = 0.0377, g = 9.80665;
  const Vector3 l{3e-9, 5e-9, -7e-9};
  const double C_II = 2e-9, C_SS = 5e-9, C_IS = 3e-10, C_IO = -4e-10, C_SO = 6e-10, C_OO = 1e-9;
  const auto truth = truth_of(model(), {{"angular_momentum", "0.0377 kg*m^2/s"},
                                        {"mass", "0.45 kg"},
                                        {"mass_offset_I", "3 nm"},
                                        {"mass_offset_S", "-7 nm"},
                                        {"compliance_II", "2e-9 m/N"},
                                        {"compliance_SS", "5e-9 m/N"},
                                        {"compliance_IS", "3e-10 m/N"},
                                        {"compliance_IO", "-4e-10 m/N"},
                                        {"compliance_SO", "6e-10 m/N"},
                                        {"disturbance_torque", "2e-7 N*m"}});
  for (int n = 0; n < 50; ++n) {
    Felt felt;
    felt.specific_force = any(RandomStream(3), n, 20.0 * g);
    const Vector3 f = felt.specific_force;
    const Vector3 lag = {C_II * f.x + C_IO * f.y + C_IS * f.z, C_IO * f.x + C_OO * f.y + C_SO * f.z,
                         C_IS * f.x + C_SO * f.y + C_SS * f.z};
    const Vector3 torque = cross(l - m * lag, -m * f);
    const double drift = (2e-7 + torque.y) / H;
    EXPECT_NEAR(indicated(model(), truth, felt), drift, 1e-14 * (1.0 + std::abs(drift)));
  }
}

TEST(SdofGyro, RecordedOutputFollowsTheFullLoopInMotion) {
  // all three axes in slow motion; the only part of first order that the terms behind the loop do not have is the lag
  // of the tilt in -H/k w_I w_S: (H/k)(D/k) w_I' w_S
  const Gimbal gimbal;
  const auto truth = truth_of_gimbal();
  const double step = 1e-3, a = 0.5;
  const double nu[3] = {2.0, 3.1, 1.3};
  const auto motion = [&](double t) {
    return std::pair{
        Vector3{a * std::sin(nu[0] * t), a * std::cos(nu[1] * t), a * std::sin(nu[2] * t)},
        Vector3{a * nu[0] * std::cos(nu[0] * t), -a * nu[1] * std::sin(nu[1] * t), a * nu[2] * std::cos(nu[2] * t)}};
  };
  std::vector<double> samples, torquer;
  Swing beta;
  for (int n = 0; n < 3000; ++n) {
    const double t = step * n;
    Felt felt;
    std::tie(felt.rate, felt.angular_acceleration) = motion(t);
    samples.push_back(indicated(model(), truth, felt));
    torquer.push_back(gimbal.k * beta.angle / gimbal.H);
    for (int i = 0; i < 10; ++i)
      beta = runge_kutta(beta, t + 1e-4 * i, 1e-4, [&](double when, Swing b) {
        const auto [w, w_dot] = motion(when);
        return gimbal.acceleration(b, w, w_dot);
      });
  }
  const auto unfiltered = samples;
  const auto recorded = model().record(truth, 0, step, RandomStream(1));
  recorded.response(samples);
  double worst = 0.0, worst_without = 0.0;
  for (std::size_t n = 200; n < samples.size(); ++n) {
    worst = std::max(worst, std::abs(samples[n] - torquer[n]));
    worst_without = std::max(worst_without, std::abs(unfiltered[n] - torquer[n]));
  }
  const double lag = gimbal.D / gimbal.k, tilt = gimbal.H / gimbal.k;
  EXPECT_LT(worst, 1.05 * tilt * lag * nu[0] * a * a);                 // 1.9e-6 rad/s
  EXPECT_NEAR(worst_without, lag * nu[0] * a, 0.1 * lag * nu[0] * a);  // 2e-3 rad/s
}

TEST(SdofGyro, ConingLeavesTheMeanThatTheTiltsLagPredicts) {
  // w_I = a cos(nu t), w_S leads by 90 deg: mean (H/k)(D/k) nu a^2/2, not in the table of terms
  const Gimbal gimbal;
  const double nu = 2.0 * std::numbers::pi * 2.0, a = 0.3, step = 1e-4;
  double sum = 0.0;
  Swing beta;
  for (int n = 0; n < 15000; ++n) {  // three periods, the last two count
    if (n >= 5000) sum += gimbal.k * beta.angle / gimbal.H / 10000.0;
    beta = runge_kutta(beta, step * n, step, [&](double t, Swing b) {
      return gimbal.acceleration(b, {a * std::cos(nu * t), 0.0, -a * std::sin(nu * t)},
                                 {-a * nu * std::sin(nu * t), 0.0, -a * nu * std::cos(nu * t)});
    });
  }
  const double expected = gimbal.H / gimbal.k * gimbal.D / gimbal.k * nu * a * a / 2.0;
  EXPECT_NEAR(sum, expected, 0.02 * expected);  // next order: (nu D/k)^2 = 6e-4, and products of inertia 1e-7 a^2
}

TEST(SdofGyro, NumbersOfTheLecture) {
  // ring of 100 g and radius 1 cm at 600 rev/s; a hair of 10 mg at 1 cm, 9.8 N/kg, H rounded to 0.038
  const auto ring = truth_of(
      model(), {{"rotor_inertia", "1e-5 kg*m^2"}, {"spin_rate", "36000 rpm"}, {"disturbance_torque", "1 N*m"}});
  EXPECT_NEAR(1.0 / model().coefficients(ring).at("D_F"), 0.037699112, 1e-9);
  const auto hair = truth_of(model(), {{"angular_momentum", "0.038 kg*m^2/s"}, {"disturbance_torque", "9.8e-7 N*m"}});
  EXPECT_NEAR(Unit::parse("deg/h").from_si(model().coefficients(hair).at("D_F")), 5.319461, 1e-6);
  // mass offset for 0.1 deg/h at 9.8 m/s^2: 18.79890 nm
  const auto offset =
      truth_of(model(), {{"angular_momentum", "0.038 kg*m^2/s"}, {"mass", "0.1 kg"}, {"mass_offset_I", "18.79890 nm"}});
  EXPECT_NEAR(Unit::parse("deg/h").from_si(9.8 * model().coefficients(offset).at("D_S")), 0.1, 1e-7);
}

TEST(SdofGyro, CurrentRangeAndExplicitCoefficients) {
  const auto truth = truth_of(model(), {{"output", "current"},
                                        {"torquer_scale_factor", "510 deg/h/mA"},
                                        {"range", "15 deg/s"},
                                        {"range_negative", "10 deg/s"},
                                        {"angular_momentum", "0.038 kg*m^2/s"},
                                        {"disturbance_torque", "9.8e-7 N*m"},
                                        {"D_F", "2 deg/h"}});
  EXPECT_DOUBLE_EQ(indicated(model(), truth, Felt{}), si(2.0, "deg/h"));
  const auto recorded = model().record(truth, 0, 0.01, RandomStream(1));
  EXPECT_EQ(recorded.unit, "mA");
  std::vector<double> samples{si(1020.0, "deg/h"), si(40.0, "deg/s"), si(-40.0, "deg/s")};
  recorded.response(samples);
  EXPECT_NEAR(samples[0], 2e-3, 1e-15);
  EXPECT_NEAR(samples[1], 15.0 * 3600.0 / 510.0 * 1e-3, 1e-12);
  EXPECT_NEAR(samples[2], -10.0 * 3600.0 / 510.0 * 1e-3, 1e-12);
}

TEST(SdofGyro, CurrentFromTheTorquerAndTheMomentum) {
  const auto truth = truth_of(
      model(), {{"output", "current"}, {"torquer_constant", "0.1 N*m/A"}, {"angular_momentum", "0.04 kg*m^2/s"}});
  std::vector<double> samples{2.5};
  model().record(truth, 0, 0.01, RandomStream(1)).response(samples);
  EXPECT_DOUBLE_EQ(samples[0], 1.0);
}

TEST(SdofGyro, ListsAllThatThePhysicsLacks) {
  const auto truth = truth_of(model(), {{"mass_offset_I", "3 nm"},
                                        {"gimbal_inertia_S", "1e-5 kg*m^2"},
                                        {"pickoff_gain", "1 V/rad"},
                                        {"loop_stiffness", "1 N*m/rad"}});
  EXPECT_EQ(problems_of(model(), truth), 5u);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"-1e-5 kg*m^2"}, .key = "gimbal_inertia_S"}, [&] {
    truth_of(model(), {{"gimbal_inertia_S", "-1e-5 kg*m^2"}});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "needs torquer_scale_factor"}, [&] {
    model().record(truth_of(model(), {{"output", "current"}}), 0, 0.01, RandomStream(1));
  }));
  EXPECT_TRUE(model().coefficients(truth_of(model(), {})).empty());
  EXPECT_FALSE(model().record(truth_of(model(), {}), 0, 0.01, RandomStream(1)).response);
}

}  // namespace
}  // namespace tumble::sdof_gyro_test
