#include "tumble/reduce/imu/axes_check.hpp"

#include <gtest/gtest.h>

#include "tumble/math/random.hpp"

namespace tumble::imu {
namespace {

const std::vector<Vector3> faces{{0, 0, 9.8}, {0, 0, -9.8}, {0, 9.8, 0}, {0, -9.8, 0}, {9.8, 0, 0}, {-9.8, 0, 0}};
const std::vector<std::string> labels{"z up", "z down", "y up", "y down", "x up", "x down"};

/// Output i shows `ratio[i]` of axis along[i], 2 % of the others and a bias.
std::vector<Vector3> shown_by(const std::vector<Vector3>& felt, std::array<std::size_t, 3> along,
                              std::array<double, 3> ratio) {
  std::vector<Vector3> out;
  for (const auto& f : felt) {
    std::array<double, 3> y{};
    for (std::size_t i = 0; i < 3; ++i)
      y[i] = ratio[i] * (component(f, along[i]) + 0.02 * component(f, (along[i] + 1) % 3) + 0.3);
    out.push_back({y[0], y[1], y[2]});
  }
  return out;
}

std::string said(Kind kind, const std::vector<Vector3>& felt, const std::vector<Vector3>& shown) {
  std::string all;
  for (const auto& finding : about_triad(kind, felt, shown, labels)) all += finding.message + "\n";
  return all;
}

TEST(AxesCheck, SoundTriadIsSilent) {
  EXPECT_EQ(said(Kind::accelerometer, faces, shown_by(faces, {0, 1, 2}, {1, 1, 1})), "");
  EXPECT_EQ(said(Kind::gyro, faces, shown_by(faces, {0, 1, 2}, {1.3, 0.8, 1})), "");
}

TEST(AxesCheck, NamesExchangedAndReversedAxes) {
  const auto exchanged = said(Kind::accelerometer, faces, shown_by(faces, {1, 0, 2}, {1, 1, 1}));
  EXPECT_NE(exchanged.find("accelerometer_x and accelerometer_y look exchanged: the triad is left-handed"),
            std::string::npos)
      << exchanged;
  const auto turned = said(Kind::gyro, faces, shown_by(faces, {1, 0, 2}, {1, -1, 1}));
  EXPECT_NE(turned.find("gyro_x and gyro_y look exchanged, and gyro_y is reversed. Set"), std::string::npos) << turned;
  const auto on = said(Kind::gyro, faces, shown_by(faces, {1, 2, 0}, {1, 1, 1}));
  EXPECT_NE(on.find("gyro_x shows y, gyro_y shows z, gyro_z shows x. "), std::string::npos) << on;
  const auto one = said(Kind::gyro, faces, shown_by(faces, {0, 1, 2}, {1, 1, -1}));
  EXPECT_NE(one.find("gyro_z is reversed: the triad is left-handed"), std::string::npos) << one;
}

TEST(AxesCheck, NamesTheSignOfGravityAndUnits) {
  const auto sign = said(Kind::accelerometer, faces, shown_by(faces, {0, 1, 2}, {-1, -1, -1}));
  EXPECT_NE(sign.find("the sign of gravity is inverted"), std::string::npos) << sign;
  const double g = 9.80665;
  const auto unit = said(Kind::accelerometer, faces, shown_by(faces, {0, 1, 2}, {1 / g, 1 / g, 1 / g}));
  EXPECT_NE(unit.find("values in g are read as m/s^2"), std::string::npos) << unit;
  const auto rate = said(Kind::gyro, faces, shown_by(faces, {0, 1, 2}, {57.3, 57.3, 57.3}));
  EXPECT_NE(rate.find("values in deg/s are read as rad/s"), std::string::npos) << rate;
}

TEST(AxesCheck, NamesPositionsInAnotherOrder) {
  auto shown = shown_by(faces, {0, 1, 2}, {1, 1, 1});
  std::swap(shown[0], shown[4]);
  const auto two = said(Kind::accelerometer, faces, shown);
  EXPECT_NE(two.find("'z up' reads as 'x up' should, 'x up' reads as 'z up' should"), std::string::npos) << two;
  // all six in another order, which no exchange of axes explains
  const auto order = shown_by({faces[2], faces[4], faces[1], faces[5], faces[3], faces[0]}, {0, 1, 2}, {1, 1, 1});
  const auto all = said(Kind::accelerometer, faces, order);
  EXPECT_NE(all.find("'z up' reads as 'y up' should"), std::string::npos) << all;
}

TEST(AxesCheck, AnAxisThatNothingWasFeltAlongKeepsItsName) {
  const std::vector<Vector3> about_z{{0, 0, 1}, {0, 0, -1}};
  const auto seen = axes_seen(about_z, shown_by(about_z, {0, 1, 2}, {1, 1, -1}));
  EXPECT_EQ(seen.along, (std::array<std::size_t, 3>{0, 1, 2}));
  EXPECT_LT(seen.ratio[2], 0.0);
  EXPECT_TRUE(std::isnan(seen.ratio[0]));
}

TEST(AxesCheck, ReadsAMatrix) {
  Matrix response(3, 3);
  response(0, 1) = -0.98;
  response(1, 0) = 1.01;
  response(2, 2) = 1.0;
  response(0, 0) = 0.03;
  const auto seen = axes_seen(response);
  EXPECT_EQ(seen.along, (std::array<std::size_t, 3>{1, 0, 2}));
  EXPECT_EQ(about_axes(Kind::gyro, seen).size(), 1u);
}

}  // namespace
}  // namespace tumble::imu
