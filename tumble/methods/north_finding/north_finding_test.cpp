#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "tumble/earth/earth.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/north_finding/model.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/error.hpp"

namespace tumble::methods {
namespace {

const double arcsec = si(1.0, "arcsec");
const double degree = si(1.0, "deg");
const double latitude = 34.25 * degree;

const Method& method() { return find_method("north_finding"); }

/// A two-axis table whose inner axis turns, without errors: its outer axis along the base's x at index 0. No noise.
Plan table_at(double azimuth, double pitch, double roll, const std::vector<double>& angles, double stay = 60.0) {
  Plan plan = trial_plan("north_finding", method().options(), "imu", "two_axis_table", 1.0);
  plan.rig.set_flag("ideal", true);
  plan.rig.set_number("outer_azimuth", azimuth, Unit::parse("deg"));
  plan.rig.set_number("outer_elevation", pitch, Unit::parse("deg"));
  plan.settings.set_number("latitude_sd", 0.0, Unit::parse("arcsec"));
  plan.channels["gyro"] = {{"gyro_x", std::nullopt}};
  int number = 0;
  for (const double angle : angles)
    plan.schedule.push_back(
        {std::to_string(++number),
         stay,
         1,
         {{"outer", {.kind = Motion::Kind::hold, .value = roll}},
          {"inner", {.kind = Motion::Kind::slew, .value = si(50.0, "deg/s"), .to = angle * degree}}}});
  return plan;
}

const std::vector<double> palindrome{0, 90, 180, 270, 270, 180, 90, 0};

Estimate identified(const Plan& plan, const Recording& recording) {
  return method().identify(Evidence{plan, {recording}, {}}, {});
}

Estimate identified(const Plan& plan) { return identified(plan, simulate(plan, 1, {})); }

/// The gyro alone: accelerometers without noise on a level base would show one and the same number.
Recording gyro_alone(const Plan& plan) {
  Recording recording = simulate(plan, 1, {});
  std::erase_if(recording.channels, [](const Channel& output) { return output.name.starts_with("accelerometer"); });
  return recording;
}

double sd(const Estimate& estimate, const char* name) {
  const auto* parameter = find_parameter(estimate, name);
  return standard_uncertainty(estimate, static_cast<std::size_t>(parameter - estimate.parameters.data()));
}

double apart(double a, double b) { return std::abs(std::remainder(a - b, 2.0 * std::numbers::pi)); }

Refused refusal(const Plan& plan, const Recording& recording) {
  return tumble::refusal(method(), {plan, {recording}, {}});
}

Channel& channel(Recording& recording, const std::string& name) {
  return *std::ranges::find(recording.channels, name, &Channel::name);
}

void without_angles(Recording& recording) {
  std::erase_if(recording.channels, [](const Channel& one) { return one.name.ends_with("_angle"); });
}

/// In column `column` of the table's row that begins with `first`.
double cell(const Estimate& estimate, const char* table, const std::string& first, std::size_t column) {
  for (const auto& row : find_table(estimate, table)->rows)
    if (std::get<std::string>(row[0]) == first) return std::get<double>(row[column]);
  ADD_FAILURE() << first;
  return NAN;
}

TEST(NorthFinding, TiltOf217) {
  // A base whose level axes, x at 37 deg, were turned by one rotation vector of (1, 0.5) deg.
  const double heading = 37.0 * degree;
  const Vector3 tilt{1.0 * degree, 0.5 * degree, 0.0};
  const Rotation base = about((1.0 / norm(tilt)) * tilt, norm(tilt));
  const double c = std::cos(latitude), s = std::sin(latitude);
  const Vector3 rate = base * (earth_rate * Vector3{c * std::cos(heading), c * std::sin(heading), s});
  const Vector3 up = base * Vector3{0.0, 0.0, 1.0};
  const double truth = heading - std::atan2(base.x.y, base.x.x);  // of the horizontal projection of the base's x
  // To half of the last digit that docs/equations print with (2.17).
  EXPECT_NEAR((std::atan2(rate.y, rate.x) - truth) / arcsec, 2697.0, 0.5);
  const double vertical = earth_rate * s;
  EXPECT_NEAR((std::atan2(rate.y - vertical * up.y, rate.x - vertical * up.x) - truth) / arcsec, 8.7, 0.05);
  EXPECT_NEAR(north_finding::exact_azimuth(rate.x, rate.y, up.x, up.y, latitude) - truth, 0.0, 1e-14);
  const double p = std::asin(up.x), r = std::atan2(up.y, up.z);
  const auto directions = north_finding::directions_of(truth, p, r);
  EXPECT_NEAR(norm(earth_rate * (c * directions.north + s * directions.up) - rate), 0.0, 1e-18);
}

TEST(NorthFinding, IsExactAtAnyHeadingAndTilt) {
  for (int k = 0; k < 24; ++k) {
    const double heading = (15.0 * k + 3.0) * degree;
    Plan plan = table_at(heading, 6.0 * degree, -8.0 * degree, palindrome);
    set_truth(plan, "gyro_x_bias", 5.0, "deg/h");
    set_truth(plan, "accelerometer_x_bias", 3.0, "mg");
    set_truth(plan, "accelerometer_y_bias", -2.0, "mg");
    const auto estimate = identified(plan);
    // the gyro's samples are rounded to 1e-16 of 5 deg/h, a part in 1e15 of the Earth's rate
    EXPECT_LT(apart(value(estimate, "azimuth"), heading), 1e-11) << k;
    EXPECT_NEAR(value(estimate, "pitch"), 6.0 * degree, 1e-11);
    EXPECT_NEAR(value(estimate, "roll"), -8.0 * degree, 1e-11);
    EXPECT_NEAR(value(estimate, "bias"), si(5.0, "deg/h"), 1e-15);
    EXPECT_NEAR(cell(estimate, "methods", "tilt exact (2.12)", 2), 0.0, 1e-10);
  }
}

TEST(NorthFinding, GammaYIsTheAzimuthOf210AndACalibrationTakesItOff) {
  Plan plan = table_at(200.0 * degree, 0.0, 0.0, palindrome);
  set_truth(plan, "gyro_x_misalignment_y", 300.0, "arcsec");
  set_truth(plan, "gyro_x_misalignment_z", -200.0, "arcsec");
  set_truth(plan, "gyro_angle_random_walk", 1e-5, "deg/sqrt(h)");
  constexpr double four_sd = 4.0 * 0.7;  // [arcsec] that this noise makes
  const Recording recording = gyro_alone(plan);
  const auto nominal = identified(plan, recording);
  EXPECT_NEAR((value(nominal, "azimuth") - 200.0 * degree) / arcsec, -300.0, four_sd);
  auto result = std::make_shared<Estimate>();
  result->parameters = {{"gyro.misalignment_y", "", Unit::parse("arcsec"), 300.0 * arcsec, ""},
                        {"gyro.misalignment_z", "", Unit::parse("arcsec"), -200.0 * arcsec, ""}};
  result->covariance = Matrix(2, 2);
  result->covariance(0, 0) = std::pow(20.0 * arcsec, 2);
  plan.calibration = {"result.json", "", result};
  const auto estimate = identified(plan, recording);
  EXPECT_NEAR((value(estimate, "azimuth") - 200.0 * degree) / arcsec, 0.0, four_sd);
  EXPECT_NEAR(sd(estimate, "azimuth") / arcsec, 20.0, 0.1);  // the calibration's, in full
  EXPECT_NEAR(cell(estimate, "before_after", "nominal", 1), value(nominal, "azimuth"), 1e-12);
  plan.calibration.result = std::make_shared<const Estimate>();
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"result.json"}, .part = "gyro.misalignment_y"},
                      refusal(plan, recording)));
}

TEST(NorthFinding, UncertaintyFromNoiseIsThatOf214) {
  Plan plan = table_at(70.0 * degree, 0.0, 0.0, {0, 90, 180, 270}, 300.0);
  set_truth(plan, "gyro_angle_random_walk", 0.005, "deg/sqrt(h)");
  set_truth(plan, "accelerometer_angle_random_walk", 1e-6, "(m/s)/sqrt(h)");
  const auto estimate = method().predict(plan);
  double inverse = 0.0;
  for (const auto& row : find_table(estimate, "positions")->rows) inverse += 0.25 / std::get<double>(row[3]);
  const double rate_sd = si(0.005, "deg/sqrt(h)") * std::sqrt(inverse);
  // at 70 deg the two pairs count as sin^2 and cos^2; their stays differ by 2 % at most
  EXPECT_NEAR(sd(estimate, "azimuth") / (rate_sd / (std::numbers::sqrt2 * earth_rate * std::cos(latitude))), 1.0, 0.01);
  EXPECT_NEAR(si(1.0, "arcmin") * 3.4, sd(estimate, "azimuth"), 0.05 * si(1.0, "arcmin"));
}

TEST(NorthFinding, ErrorOfAnIndexIsThatOf215) {
  const double a = 25.0 * degree;
  const std::vector<double> angles{0, 90, 180, 270};
  const std::vector<double> off{40, -25, 60, 10};  // arcsec
  std::vector<double> real = angles;
  for (std::size_t k = 0; k < 4; ++k) real[k] += off[k] / 3600.0;
  const Plan plan = table_at(a, 0.0, 0.0, angles);
  Recording recording = gyro_alone(table_at(a, 0.0, 0.0, real));
  const auto recorded = identified(plan, recording);  // the encoder shows them
  EXPECT_NEAR(value(recorded, "azimuth") - a, 0.0, 1e-11);
  EXPECT_EQ(find_table(recorded, "angles")->rows.size(), 8u);  // outer and inner
  without_angles(recording);
  const auto estimate = identified(plan, recording);
  const double s = std::sin(a), c = std::cos(a);
  const double expected = -0.5 * (s * s * (off[0] + off[2]) + c * c * (off[1] + off[3]));
  EXPECT_NEAR((value(estimate, "azimuth") - a) / arcsec, expected, 0.02);  // second order: (60 arcsec)^2 is 0.02
}

TEST(NorthFinding, ErrorsOfTheTableCarryItsKey) {
  Plan plan = table_at(25.0 * degree, 0.0, 0.0, {0, 90, 180, 270});
  plan.rig.set_flag("ideal", false);
  plan.rig_equipment = "table 7, certificate 12";
  const auto estimate = identified(plan, gyro_alone(plan));
  std::size_t keyed = 0;
  for (const auto& line : estimate.budget) {
    if (line.key != plan.rig_equipment) continue;
    ++keyed;
    EXPECT_EQ(line.factor.columns, 1u) << line.source;
  }
  EXPECT_GT(keyed, 0u);
}

TEST(NorthFinding, DriftShiftsTheAzimuthAsOf216UnlessTheOrderCancelsIt) {
  const double a = 25.0 * degree, stay = 100.0;
  const double step = si(0.05, "deg/h/h") * stay, c = earth_rate * std::cos(latitude);
  const auto shift = [&](const std::vector<double>& angles, const char* drift) {
    Plan plan = table_at(a, 0.0, 0.0, angles, stay);
    plan.settings.set_word("drift", drift);
    set_truth(plan, "gyro_rate_ramp", 0.05, "deg/h/h");
    return identified(plan, gyro_alone(plan));
  };
  const double whole = step / c * (std::sin(a) - std::cos(a));
  // the stays are not quite equally far apart: the first needs no turn
  EXPECT_NEAR(value(shift({0, 90, 180, 270}, "no"), "azimuth") - a, whole, 0.02 * std::abs(whole));
  EXPECT_NEAR(value(shift({0, 180, 90, 270}, "no"), "azimuth") - a, 0.5 * whole, 0.03 * std::abs(whole));
  EXPECT_NEAR(value(shift(palindrome, "no"), "azimuth") - a, 0.0, 0.02 * std::abs(whole));
  const auto fitted = shift(palindrome, "auto");
  EXPECT_NEAR(value(fitted, "azimuth") - a, 0.0, 1e-11);
  EXPECT_NEAR(value(fitted, "drift"), si(0.05, "deg/h/h"), 1e-6 * si(0.05, "deg/h/h"));
  EXPECT_NE(finding_of(shift({0, 90, 180, 270}, "auto").findings, "drift_moves_azimuth"), nullptr);
}

// With fewer than six positions the drift is no term of its own: what it leaves in the residuals is in the slow noise.
// Drifts from none to one that shifts the azimuth by 7 times its white noise: of 60 intervals of 95 % 57 hold, +- 1.7.
TEST(NorthFinding, ADriftThatIsNoTermIsInTheInterval) {
  for (const auto& angles :
       std::vector<std::vector<double>>{{0, 90, 180, 270}, {0, 180, 90, 270}, {0, 90, 180, 270, 0}}) {
    int held = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
      Plan plan = table_at(25.0 * degree, 0.0, 0.0, angles, 100.0);
      set_truth(plan, "gyro_angle_random_walk", 0.003, "deg/sqrt(h)");
      set_truth(plan, "gyro_rate_ramp", 4.0 * RandomStream(seed).uniform(0), "deg/h/h");
      Recording recording = simulate(plan, seed, {});
      std::erase_if(recording.channels, [](const Channel& one) { return one.name.starts_with("accelerometer"); });
      const auto estimate = identified(plan, recording);
      const double half =
          student_quantile(0.975, find_parameter(estimate, "azimuth")->degrees_of_freedom) * sd(estimate, "azimuth");
      held += apart(value(estimate, "azimuth"), 25.0 * degree) < half ? 1 : 0;
    }
    EXPECT_GT(held, 57 - 4 * 1.7);
  }
}

TEST(NorthFinding, TwoPositionsNeedTheScaleFactorAndAHint) {
  const double a = 75.0 * degree;
  Plan plan = table_at(a, 1.0 * degree, 0.0, {0, 180, 180, 0});
  const Recording recording = simulate(plan, 1, {});
  const auto estimate = identified(plan, recording);
  EXPECT_TRUE(has_error(estimate.findings, "two_azimuths"));
  plan.settings.set_number("azimuth_about", 80.0 * degree, Unit::parse("deg"));
  EXPECT_LT(apart(value(identified(plan, recording), "azimuth"), a), 1e-10);
  plan.settings.set_number("azimuth_about", -80.0 * degree, Unit::parse("deg"));
  EXPECT_LT(apart(value(identified(plan, recording), "azimuth"), -a), 0.1);
  // (2.11): sd = sigma_W/(2 w_ie cos(phi) sin(A)) x sqrt(2) for one pair
  Plan noisy = table_at(a, 0.0, 0.0, {0, 180, 180, 0}, 102.0);
  set_truth(noisy, "gyro_angle_random_walk", 0.002, "deg/sqrt(h)");
  set_truth(noisy, "accelerometer_angle_random_walk", 1e-6, "(m/s)/sqrt(h)");
  const double expected = si(0.002, "deg/sqrt(h)") / std::sqrt(2.0 * 98.0) /
                          (std::numbers::sqrt2 * earth_rate * std::cos(latitude) * std::sin(a));
  EXPECT_NEAR(sd(method().predict(noisy), "azimuth") / expected, 1.0, 0.03);
}

TEST(NorthFinding, TurningTableWithAccelerometers) {
  const double a = 311.0 * degree;
  Plan plan = table_at(a, 2.0 * degree, -1.0 * degree, {});
  for (const double rate : {3.0, -3.0})
    plan.schedule.push_back({rate > 0.0 ? "forwards" : "back",
                             360.0,
                             1,
                             {{"outer", {.kind = Motion::Kind::hold, .value = -1.0 * degree}},
                              {"inner", {.kind = Motion::Kind::rate, .value = si(rate, "deg/s")}}}});
  set_truth(plan, "gyro_x_bias", 2.0, "deg/h");
  set_truth(plan, "gyro_x_misalignment_z", 100.0, "arcsec");
  plan.truth.set_integer("oversampling", 8);
  const auto estimate = identified(plan);
  // the simulated samples are means of 8 instants of a turn by 3 deg each: off by (pi/120/8)^2/6 of the rate, in both
  // components alike
  EXPECT_LT(apart(value(estimate, "azimuth"), a), 1e-6);
  EXPECT_NEAR(value(estimate, "misalignment_z"), 100.0 * arcsec, 0.01 * arcsec);
  EXPECT_NE(finding_of(estimate.findings, "continuous_turning"), nullptr);
}

TEST(NorthFinding, VoltageOfUnknownScaleFactor) {
  const double a = 123.0 * degree;
  const Plan plan = table_at(a, 0.0, 0.0, palindrome);
  Recording recording = gyro_alone(plan);
  auto& gyro = channel(recording, "gyro_x");
  for (double& v : gyro.values) v = 0.02 / si(1.0, "deg/h") * v - 0.06;
  gyro.unit = Unit::parse("V");
  gyro.kind = QuantityKind::other;
  const auto estimate = identified(plan, recording);
  EXPECT_LT(apart(value(estimate, "azimuth"), a), 1e-10);
  EXPECT_NEAR(value(estimate, "scale_factor") / (0.02 / si(1.0, "deg/h")), 1.0, 1e-10);
}

TEST(NorthFinding, LevelIsTakenFromTheRigWithoutAccelerometers) {
  const double a = 37.0 * degree;
  Plan plan = table_at(a, 0.0, 0.0, palindrome);
  plan.rig.set_flag("ideal", false);
  for (const char* sd : {"repeatability_sd", "wobble_once_sd", "wobble_twice_sd"})
    plan.rig.set_number(sd, 0.0, Unit::parse("arcsec"));
  plan.rig.set_number("orthogonality_sd", 0.0, Unit::parse("arcsec"));
  plan.rig.set_number("mount_sd", 0.0, Unit::parse("arcsec"));
  plan.rig.set_number("index_zero_sd", 0.0, Unit::parse("arcsec"));
  plan.rig.set_number("level_sd", 100.0 * arcsec, Unit::parse("arcsec"));
  const auto estimate = identified(plan, gyro_alone(plan));
  EXPECT_EQ(find_parameter(estimate, "pitch"), nullptr);
  EXPECT_EQ(text_of(estimate.findings, "tilt_of_the_rig", "reason"), "no_accelerometer_shows_tilt");
  // (2.17): tan(phi) (rho_X cos A + rho_Y sin A) with equal sd of both
  EXPECT_NEAR(sd(estimate, "azimuth") / (std::tan(latitude) * 100.0 * arcsec), 1.0, 0.01);
}

TEST(NorthFinding, WrongEvidenceIsNamed) {
  const Plan plan = table_at(37.0 * degree, 1.0 * degree, 2.0 * degree, palindrome);
  const Recording good = simulate(plan, 1, {});
  const auto changed = [&](auto change) {
    Recording recording = good;
    change(recording);
    return identified(plan, recording);
  };
  EXPECT_TRUE(errors_among(identified(plan, good).findings).empty());
  const auto scaled = [&](const char* name, double factor, double offset = 0.0) {
    return changed([&](Recording& r) {
      for (double& v : channel(r, name).values) v = factor * v + offset;
    });
  };
  const auto reversed = scaled("accelerometer_y", -1.0).findings;
  EXPECT_TRUE(has_error(reversed, "opposite_tilts"));
  EXPECT_EQ(text_of(reversed, "accelerometer_reversed", "channel"), "accelerometer_y");
  const auto swapped = [&](const char* one, const char* other) {
    return changed([&](Recording& r) { std::swap(channel(r, one).values, channel(r, other).values); }).findings;
  };
  EXPECT_TRUE(has_error(swapped("accelerometer_x", "accelerometer_y"), "opposite_tilts"));
  EXPECT_TRUE(has_error(swapped("accelerometer_x", "accelerometer_y"), "accelerometers_exchanged"));
  EXPECT_TRUE(has_error(scaled("accelerometer_x", 9.8).findings, "different_tilts"));
  EXPECT_TRUE(has_error(scaled("accelerometer_x", 9.8).findings, "channel_unit_mistaken"));
  EXPECT_TRUE(has_error(scaled("gyro_x", degree).findings, "unit_mistaken"));
  const auto per_minute = scaled("gyro_x", 60.0), locked_in = scaled("gyro_x", 1e-3, 1e-6);
  EXPECT_TRUE(has_error(per_minute.findings, "wrong_horizontal_rate"));
  EXPECT_EQ(text_of(per_minute.findings, "wrong_horizontal_rate", "suspicion"), "rate_in_wrong_time_unit");
  EXPECT_TRUE(has_error(locked_in.findings, "wrong_horizontal_rate"));
  EXPECT_EQ(text_of(locked_in.findings, "wrong_horizontal_rate", "suspicion"), "gyro_misses_earth_rate");
  Plan exchanged = plan;
  std::swap(exchanged.schedule[2].axes, exchanged.schedule[4].axes);
  const auto mended = identified(exchanged, good);  // by the recorded angles
  EXPECT_LT(apart(value(mended, "azimuth"), 37.0 * degree), 1e-9);
  EXPECT_TRUE(
      std::ranges::any_of(mended.findings, [](const Finding& f) { return f.severity != Finding::Severity::info; }));
  Recording blind = good;
  without_angles(blind);
  const auto of_blind = identified(exchanged, blind);
  EXPECT_TRUE(has_error(of_blind.findings, "positions_exchanged"));
  EXPECT_EQ(text_of(of_blind.findings, "positions_exchanged", "position"), "3");
  EXPECT_EQ(text_of(of_blind.findings, "positions_exchanged", "other"), "5");
}

// A latitude 1 deg off changes the horizontal rate by tan(phi) 1 deg, 1.2 % at 34 deg: far more than the uncertainties
// that are stated, less than what is let pass where nothing is stated of the scale factor.
TEST(NorthFinding, TheSizeOfTheRateIsJudgedByWhatIsStated) {
  const auto found = [](double off, bool stated) {
    Plan plan = table_at(37.0 * degree, 1.0 * degree, 2.0 * degree, palindrome);
    const Recording recording = simulate(plan, 1, {});
    plan.site->latitude += off;
    if (stated) plan.settings.set_number("gyro_scale_factor_sd", 100e-6, Unit::parse("ppm"));
    return has_error(identified(plan, recording).findings, "wrong_horizontal_rate");
  };
  EXPECT_TRUE(found(1.0 * degree, true));
  EXPECT_TRUE(found(-1.0 * degree, true));
  EXPECT_FALSE(found(1.0 * degree, false));
  EXPECT_FALSE(found(0.0, true));
}

TEST(NorthFinding, WhatCannotShowTheAzimuthIsRefused) {
  const auto refused = [&](const std::vector<double>& angles) {
    const Plan plan = table_at(37.0 * degree, 0.0, 0.0, angles);
    Recording recording = gyro_alone(plan);
    auto& values = channel(recording, "gyro_x").values;
    for (std::size_t k = 0; k < values.size(); ++k) values[k] += 1e-9 * static_cast<double>(k % 3);
    return refusal(plan, recording);
  };
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.part = "turns no axis"}, refused({0, 0})));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "same index angle"}, refused({0, 360})));
  Plan plan = table_at(37.0 * degree, 0.0, 0.0, palindrome);
  const Recording recording = gyro_alone(plan);
  plan.rig.set_number("outer_elevation", 80.0 * degree, Unit::parse("deg"));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"inner"}, .pattern = "must be vertical"},
                      refusal(plan, recording)));
}

TEST(NorthFinding, SettingsOutsideTheirRangeAreRefused) {
  Problems problems;
  resolve(method().options(), {{"averaging", "0 s", ""}, {"settling", "-1 s", ""}, {"angle_tolerance", "0 deg", ""}},
          "", problems);
  EXPECT_EQ(problems.size(), 3u);
}

}  // namespace
}  // namespace tumble::methods
