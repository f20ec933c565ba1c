// The model against the equation of motion of the pendulum, integrated in full, and against the published forms.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "tumble/math/random.hpp"
#include "tumble/math/rotation.hpp"
#include "tumble/models/testing/oscillator.hpp"
#include "tumble/models/testing/truth.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::pendulous_accelerometer_test {
namespace {

using namespace testing;

const Model& model() { return find_model("pendulous_accelerometer"); }

using Written = std::vector<std::pair<std::string, std::string>>;

/// Instrument axes (i, p, o) from the lecture's (I, O, P), o = -O.
Vector3 ipo(Vector3 IOP) { return {IOP.x, IOP.z, -IOP.y}; }

/// Pendulum of docs/equations (4.13)-(4.14), axes I, O, P as x, y, z; the angle is positive about -O.
struct Pendulum {
  double m = 0.8e-3, L = 0.01, l_I = 2e-5;
  double K = 50.0, C = 0.5, D = 3e-3, M_d0 = 4e-9;
  double J_I = 9e-8, J_O = 1e-7, J_P = 2e-8, J_IO = 1e-10, J_OP = -2e-10, J_IP = 2e-10;
  double C_II = 0.0, C_PP = 0.0, C_IP = 0.0, C_IO = 0.0, C_PO = 0.0;

  Vector3 deflection(Vector3 f) const {
    return -m *
           Vector3{C_II * f.x + C_IO * f.y + C_IP * f.z, C_IO * f.x + C_PO * f.z, C_IP * f.x + C_PO * f.y + C_PP * f.z};
  }

  /// theta'' at specific force f of the hinge, rate w and acceleration w_dot of the case: second component of
  /// d(J w)/dt + w x J w = M + arm x (-m f) in the pendulum's frame, J about the hinge; nothing is left out.
  double acceleration(Swing theta, Vector3 f, Vector3 w, Vector3 w_dot) const {
    const Rotation pendulum_from_case = about_y(-theta.angle);
    const Vector3 carried = pendulum_from_case * w, relative{0.0, -theta.rate, 0.0};
    const Vector3 W = carried + relative;
    const Vector3 W_dot = pendulum_from_case * w_dot - cross(relative, carried);  // without theta''
    const Vector3 f_A = pendulum_from_case * f;
    const Vector3 momentum = {J_I * W.x - J_IO * W.y - J_IP * W.z, 0.0, -J_IP * W.x - J_OP * W.y + J_P * W.z};
    const double inertial = -J_IO * W_dot.x + J_O * W_dot.y - J_OP * W_dot.z + W.z * momentum.x - W.x * momentum.z;
    const double weight = cross(Vector3{l_I, 0.0, L} + deflection(f_A), -m * f_A).y;
    return (inertial - weight + M_d0 - D * theta.rate - (C + K) * theta.angle) / J_O;
  }

  /// Torquer current over its scale factor K_I [m/s^2] once the loop has settled.
  double steady(Vector3 f, Vector3 w, Vector3 w_dot) const {
    Swing theta;
    const double step = 1e-5;  // w_n = 22 krad/s, zeta 0.67: 3 ms are 45 time constants
    for (int n = 0; n < 300; ++n)
      theta = runge_kutta(theta, 0.0, step, [&](double, Swing a) { return acceleration(a, f, w, w_dot); });
    return (K + C) * theta.angle / (m * L);
  }
};

/// The same pendulum, without compliance, as a plan writes it.
Settings truth_of_pendulum(const Written& more = {}) {
  Written written{{"pendulosity", "8e-6 kg*m"},
                  {"mass", "0.8e-3 kg"},
                  {"mass_offset_I", "20 um"},
                  {"servo_stiffness", "50 N*m/rad"},
                  {"hinge_stiffness", "0.5 N*m/rad"},
                  {"damping", "3e-3 N*m*s/rad"},
                  {"disturbance_torque", "4e-9 N*m"},
                  {"pendulum_inertia_I", "9e-8 kg*m^2"},
                  {"pendulum_inertia_O", "1e-7 kg*m^2"},
                  {"pendulum_inertia_P", "2e-8 kg*m^2"},
                  {"pendulum_product_IO", "1e-10 kg*m^2"},
                  {"pendulum_product_OP", "-2e-10 kg*m^2"},
                  {"pendulum_product_IP", "2e-10 kg*m^2"}};
  written.insert(written.end(), more.begin(), more.end());
  return truth_of(model(), written);
}

double worst_residual(const Settings& truth) {
  const Pendulum pendulum;
  double worst = 0.0;
  for (int n = 0; n < 100; ++n) {
    const Vector3 f = any(RandomStream(1), n, 50.0), w = any(RandomStream(2), n, 6.0);
    const Vector3 w_dot = any(RandomStream(3), n, 30.0);
    Felt felt;
    felt.specific_force = ipo(f);
    felt.rate = ipo(w);
    felt.angular_acceleration = ipo(w_dot);
    worst = std::max(worst, std::abs(pendulum.steady(f, w, w_dot) - indicated(model(), truth, felt)));
  }
  return worst;
}

TEST(PendulousAccelerometer, TermsAgreeWithTheFullEquationOfThePendulum) {
  // m L/(K + C) = 1.6e-7 rad/(m/s^2), tilt up to 8e-6 rad. Left out: tilt twice, (8e-6)^2 50 = 3e-9 m/s^2 in several
  // places; inertia times tilt driven by a_c and M_d0, 9e-3 m 72 s^-2 1e-7 = 6e-8; products of inertia times tilt,
  // (4 J_IP/mL) 8e-6 36 s^-2 = 3e-8. Up to 1e-7 together.
  EXPECT_LT(worst_residual(truth_of_pendulum()), 1e-7);
}

TEST(PendulousAccelerometer, WithoutTheTiltCouplingTheResidualIsThirtyTimesLarger) {
  // the stiffness taken away from the regressors, its other effects kept
  const double tilt = 8e-6 / 50.5, difference = 7e-8 / 50.5;
  auto uncoupled = truth_of_pendulum({{"cross_coupling_ip", fmt::format("{} (m/s^2)/(m/s^2)^2", tilt)},
                                      {"second_order_coefficient", fmt::format("{} (m/s^2)/(m/s^2)^2", tilt * 2e-3)},
                                      {"second_order_pp", fmt::format("{} (m/s^2)/(m/s^2)^2", -tilt * 2e-3)},
                                      {"C_III", fmt::format("{} 1/(rad/s)^2", -difference)},
                                      {"C_IPP", fmt::format("{} 1/(rad/s)^2", difference)},
                                      {"integrator", "true"}});
  const double worst = worst_residual(uncoupled);
  EXPECT_GT(worst, 1e-6);  // tilt f_P a_c up to 1.6e-7 * 50 * 0.7
  EXPECT_LT(worst, 6e-6);
}

TEST(PendulousAccelerometer, StaticTermsWithComplianceAgreeWithTheFullEquation) {
  Pendulum pendulum;
  pendulum.C_II = 4e-8, pendulum.C_PP = 1e-8, pendulum.C_IP = 3e-9, pendulum.C_IO = -2e-9, pendulum.C_PO = 5e-9;
  const auto truth = truth_of_pendulum({{"compliance_II", "4e-8 m/N"},
                                        {"compliance_PP", "1e-8 m/N"},
                                        {"compliance_IP", "3e-9 m/N"},
                                        {"compliance_IO", "-2e-9 m/N"},
                                        {"compliance_PO", "5e-9 m/N"}});
  for (int n = 0; n < 50; ++n) {
    const Vector3 f = any(RandomStream(4), n, 50.0);
    Felt felt;
    felt.specific_force = ipo(f);
    // tilt squared times f, and tilt times compliance (m C_II f/L = 1.6e-7 rad): 1e-8 m/s^2
    EXPECT_NEAR(pendulum.steady(f, {}, {}), indicated(model(), truth, felt), 1e-8);
  }
}

TEST(PendulousAccelerometer, LecturesCoefficientsBecomeThoseOfGjb2504) {
  // docs/equations (4.17) in A and m/s^2 with K_T, then divided by K_I and turned to o = -O
  const double m = 0.8e-3, L = 0.01, l_I = 2e-5, K_T = 0.3, K = 50.0, C = 0.5, T = K_T * (K + C);
  const double C_II = 4e-8, C_PP = 1e-8, C_IP = 3e-9, C_IO = -2e-9, C_PO = 5e-9;
  const double K_I = m * L / K_T, K_F = 4e-9 / K_T, K_P = -m * l_I / K_T, K_IO = -m * m * C_PO / K_T;
  const double K_OP = m * m * C_IO / K_T, K_IP = m * m * (C_II - C_PP) / K_T + m * L * m * L / T;
  const double K_II = -m * m * C_IP / K_T + m * L * m * l_I / T, K_PP = m * m * C_IP / K_T - m * L * m * l_I / T;
  const auto truth = truth_of_pendulum({{"compliance_II", "4e-8 m/N"},
                                        {"compliance_PP", "1e-8 m/N"},
                                        {"compliance_IP", "3e-9 m/N"},
                                        {"compliance_IO", "-2e-9 m/N"},
                                        {"compliance_PO", "5e-9 m/N"},
                                        {"torquer_constant", "0.3 N*m/A"},
                                        {"output", "current"}});
  for (int n = 0; n < 20; ++n) {
    const Vector3 f = any(RandomStream(5), n, 50.0);
    const double current = K / (K + C) *
                           (K_F + K_I * f.x + K_P * f.z + K_IO * f.x * f.y + K_OP * f.y * f.z + K_IP * f.x * f.z +
                            K_II * f.x * f.x + K_PP * f.z * f.z);
    Felt felt;
    felt.specific_force = ipo(f);
    std::vector<double> samples(2, indicated(model(), truth, felt));
    model().record(truth, 0, 0.01, RandomStream(1)).response(samples);
    EXPECT_NEAR(samples[1], current, 1e-14 * std::abs(50.0 * K_I));
  }
  const double g = si(1.0, "g");
  const auto of = model().coefficients(truth);
  EXPECT_NEAR(of.at("bias"), K_F / K_I, 1e-18);
  EXPECT_NEAR(of.at("second_order_coefficient") * g, K_II * g / K_I, 1e-18);
  EXPECT_NEAR(of.at("misalignment_o"), K_P / K_I, 1e-18);
}

TEST(PendulousAccelerometer, GjbTermsHaveThePublishedSigns) {  // (4.19)
  Felt felt;
  felt.specific_force = {2.0, 3.0, 5.0};
  const std::vector<std::pair<const char*, double>> expected{{"bias", 1.0},
                                                             {"scale_factor_error", 2.0},
                                                             {"second_order_coefficient", 4.0},
                                                             {"third_order_coefficient", 8.0},
                                                             {"cross_coupling_ip", 6.0},
                                                             {"cross_coupling_io", 10.0},
                                                             {"misalignment_o", 3.0},
                                                             {"misalignment_p", -5.0},
                                                             {"cross_coupling_po", 15.0},
                                                             {"second_order_pp", 9.0},
                                                             {"second_order_oo", 25.0},
                                                             {"odd_quadratic_coefficient", 4.0}};
  const auto terms = model().outputs(defaults(model().constants())).at(0).terms;
  for (std::size_t t = 0; t < expected.size(); ++t) {
    EXPECT_EQ(terms.at(t).name, expected[t].first);
    EXPECT_EQ(terms.at(t).regressor(felt), expected[t].second) << terms[t].name;
  }
}

TEST(PendulousAccelerometer, APointMassOnThePendulumShowsItsLeverArm) {
  // all mass at L along p: the instrument feels a_i at that point, r = L p: (w' x r + w x (w x r))_i
  const double L = 0.01;
  const auto truth = truth_of(model(), {{"pendulosity", "1e-5 kg*m"},
                                        {"pendulum_inertia_I", "1e-7 kg*m^2"},
                                        {"pendulum_inertia_O", "1e-7 kg*m^2"},
                                        {"pendulum_inertia_P", "1e-20 kg*m^2"}});
  for (int n = 0; n < 20; ++n) {
    Felt felt;
    felt.rate = any(RandomStream(6), n, 6.0);
    felt.angular_acceleration = any(RandomStream(7), n, 30.0);
    const Vector3 r{0.0, L, 0.0};
    const double lever = cross(felt.angular_acceleration, r).x + cross(felt.rate, cross(felt.rate, r)).x;
    EXPECT_NEAR(indicated(model(), truth, felt), lever, 1e-12);
  }
}

TEST(PendulousAccelerometer, VibrationInThePlaneOfThePendulumIsRectified) {
  // mean (m L/(K + C)) A_I A_P cos(phase)/2, below the natural frequency; 100 Hz is far below 3.6 kHz
  const Pendulum pendulum;
  const auto truth = truth_of_pendulum();
  const double A = 30.0, nu = 2.0 * std::numbers::pi * 100.0, step = 1e-5;
  const auto force = [&](double t) { return Vector3{A * std::cos(nu * t), 0.0, A * std::cos(nu * t)}; };
  Swing theta;
  double simulated = 0.0, modelled = 0.0, still = pendulum.steady({}, {}, {});
  for (int n = 0; n < 3000; ++n) {  // three periods, the last two count
    const double t = step * n;
    Felt felt;
    felt.specific_force = ipo(force(t));
    if (n >= 1000) {
      simulated += (pendulum.K + pendulum.C) * theta.angle / (pendulum.m * pendulum.L) / 2000.0;
      modelled += indicated(model(), truth, felt) / 2000.0;
    }
    theta = runge_kutta(theta, t, step,
                        [&](double when, Swing a) { return pendulum.acceleration(a, force(when), {}, {}); });
  }
  const double expected = 8e-6 / 50.5 * A * A / 2.0;
  EXPECT_NEAR(simulated - still, expected, 0.01 * expected);  // Re G - 1 = (nu/w_n)^2 = 8e-4
  EXPECT_NEAR(modelled - still, expected, 0.01 * expected);
}

TEST(PendulousAccelerometer, CountsOfARunAreWithinOnePulseOfTheIntegral) {
  const auto truth = truth_of(model(), {{"output", "count"}, {"pulse_scale_factor", "2500 pulse/s/g"}});
  const double step = 1e-3, K_1 = 2500.0 / si(1.0, "g");
  for (const std::uint64_t run : {1, 2, 3}) {
    const auto recorded = model().record(truth, 0, step, RandomStream(run));
    EXPECT_TRUE(recorded.accumulates);
    EXPECT_EQ(recorded.kind, QuantityKind::count);
    std::vector<double> samples(20000);
    RandomStream(run + 10).normal(0, samples);
    const double integral = K_1 * step * std::accumulate(samples.begin(), samples.end(), 0.0);
    recorded.response(samples);
    EXPECT_LE(std::abs(std::accumulate(samples.begin(), samples.end(), 0.0) - integral), 1.0);
  }
}

TEST(PendulousAccelerometer, FineStepsAddUpToTheCountsOfCoarseOnes) {
  const auto truth = truth_of(model(), {{"output", "count"}, {"pulse_scale_factor", "2500 pulse/s/g"}});
  std::vector<double> coarse(500, si(0.7312345, "g")), fine(5000, si(0.7312345, "g"));
  model().record(truth, 0, 1e-2, RandomStream(8)).response(coarse);
  model().record(truth, 0, 1e-3, RandomStream(8)).response(fine);
  for (std::size_t n = 0; n < coarse.size(); ++n)
    EXPECT_EQ(std::accumulate(fine.begin() + 10 * n, fine.begin() + 10 * (n + 1), 0.0), coarse[n]) << n;
}

TEST(PendulousAccelerometer, StartPhaseIsDrawnForEachPowerUp) {
  const auto truth = truth_of(model(), {{"output", "count"}, {"pulse_scale_factor", "100 pulse/s/g"}});
  const auto first_pulse = [&](std::uint64_t run) {
    std::vector<double> samples(100, si(1e-2, "g"));  // a hundredth of a pulse each
    model().record(truth, 0, 0.01, RandomStream(run)).response(samples);
    return std::find(samples.begin(), samples.end(), 1.0) - samples.begin();
  };
  EXPECT_EQ(first_pulse(1), first_pulse(1));
  EXPECT_NE(first_pulse(1), first_pulse(2));
}

TEST(PendulousAccelerometer, RangeDeadZoneResolutionAndLoop) {
  const auto truth = truth_of(model(), {{"range", "20 g"}, {"dead_zone", "10 ug"}, {"resolution", "5 ug"}});
  std::vector<double> samples{si(25.0, "g"), si(-25.0, "g"), si(-9.0, "ug"), si(12.4, "ug")};
  model().record(truth, 0, 0.01, RandomStream(1)).response(samples);
  const std::vector<double> expected{20.0, -20.0, 0.0, 10e-6};
  for (std::size_t n = 0; n < samples.size(); ++n) EXPECT_NEAR(samples[n] / si(1.0, "g"), expected[n], 1e-14);

  // 2 zeta/w_n of lag on a ramp, from the constants and from J_O, D and K + C
  for (const auto& [settings, lag] :
       {std::pair{truth_of(model(), {{"natural_frequency", "800 Hz"}}), 1.4 / (2.0 * std::numbers::pi * 800.0)},
        std::pair{truth_of_pendulum(), 3e-3 / 50.5}}) {
    std::vector<double> ramp(5000);
    for (std::size_t n = 0; n < ramp.size(); ++n) ramp[n] = 1e-4 * static_cast<double>(n);
    model().record(settings, 0, 1e-4, RandomStream(1)).response(ramp);
    EXPECT_NEAR(ramp.back(), 1e-4 * 4999.0 - lag, 1e-12);
  }
}

TEST(PendulousAccelerometer, ListsAllThatIsMissing) {
  const auto truth = truth_of(
      model(), {{"compliance_II", "1e-8 m/N"}, {"pendulum_inertia_I", "1e-7 kg*m^2"}, {"torquer_constant", "1 N*m/A"}});
  EXPECT_EQ(problems_of(model(), truth), 2u);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"-1 N*m/A"}, .key = "torquer_constant"}, [&] {
    truth_of(model(), {{"torquer_constant", "-1 N*m/A"}});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"-1 N*m/rad"}, .key = "hinge_stiffness"}, [&] {
    truth_of(model(), {{"hinge_stiffness", "-1 N*m/rad"}});
  }));
  for (const char* word : {"current", "voltage", "count"})
    EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {word}, .pattern = "not zero"}, [&] {
      model().record(truth_of(model(), {{"output", word}}), 0, 0.01, RandomStream(1));
    })) << word;
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"servo_stiffness", "pendulosity"}}, [&] {
    model().outputs(truth_of(model(), {{"servo_stiffness", "50 N*m/rad"}}));
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "range_negative needs range"}, [&] {
    model().record(truth_of(model(), {{"range_negative", "1 g"}}), 0, 0.01, RandomStream(1));
  }));
}

TEST(PendulousAccelerometer, BiasAndScaleFactorFollowTheTemperature) {
  const auto truth = truth_of(model(), {{"bias_temperature_coefficient", "30 ug/K"},
                                        {"bias_temperature_square", "0.2 ug/K^2"},
                                        {"scale_factor_temperature_coefficient", "-50 ppm/K"},
                                        {"scale_factor_temperature_square", "0.4 ppm/K^2"},
                                        {"reference_temperature", "25 degC"}});
  Felt felt;
  felt.specific_force = {5.0, 0.0, 0.0};
  felt.temperature = 273.15 + 25.0;
  EXPECT_NEAR(indicated(model(), truth, felt), 5.0, 1e-15);
  felt.temperature += 20.0;
  // 600 + 80 ug, -1000 + 160 ppm
  EXPECT_NEAR(indicated(model(), truth, felt), 5.0 * (1.0 - 840e-6) + 680e-6 * 9.80665, 1e-12);
}

}  // namespace
}  // namespace tumble::pendulous_accelerometer_test
