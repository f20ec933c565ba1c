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

Findings about(Kind kind, const std::vector<Vector3>& felt, const std::vector<Vector3>& shown) {
  return about_triad(kind, felt, shown, labels);
}

/// A name in the only finding, which has this code.
std::string name_in(const Findings& findings, const std::string& code, const std::string& name) {
  if (findings.size() != 1 || findings[0].code != code) return "not one " + code;
  for (const FindingValue& value : findings[0].values)
    if (value.name == name) return std::get<std::string>(value.value);
  return "no " + name;
}

TEST(AxesCheck, SoundTriadIsSilent) {
  EXPECT_TRUE(about(Kind::accelerometer, faces, shown_by(faces, {0, 1, 2}, {1, 1, 1})).empty());
  EXPECT_TRUE(about(Kind::gyro, faces, shown_by(faces, {0, 1, 2}, {1.3, 0.8, 1})).empty());
}

TEST(AxesCheck, NamesExchangedAndReversedAxes) {
  const auto exchanged = about(Kind::accelerometer, faces, shown_by(faces, {1, 0, 2}, {1, 1, 1}));
  EXPECT_EQ(name_in(exchanged, "axes_exchanged", "first"), "accelerometer_x");
  EXPECT_EQ(name_in(exchanged, "axes_exchanged", "second"), "accelerometer_y");
  const auto reversed = about(Kind::gyro, faces, shown_by(faces, {0, 1, 2}, {1, 1, -1}));
  EXPECT_EQ(name_in(reversed, "axis_reversed", "channel"), "gyro_z");
  const auto turned = about(Kind::gyro, faces, shown_by(faces, {1, 0, 2}, {1, -1, 1}));
  EXPECT_EQ(name_in(turned, "axes_turned", "axis_x"), "y");
  EXPECT_EQ(name_in(turned, "axes_turned", "axis_y"), "-x");
  const auto cyclic = about(Kind::gyro, faces, shown_by(faces, {1, 2, 0}, {1, 1, 1}));
  EXPECT_EQ(name_in(cyclic, "axes_turned", "output_z"), "gyro_z");
  EXPECT_EQ(name_in(cyclic, "axes_turned", "axis_z"), "x");
  const auto mirrored = about(Kind::gyro, faces, shown_by(faces, {1, 2, 0}, {1, -1, 1}));
  EXPECT_EQ(name_in(mirrored, "axes_mirrored", "axis_y"), "-z");
}

TEST(AxesCheck, NamesOneChannelInAnotherUnit) {
  const auto in_g = about(Kind::accelerometer, faces, shown_by(faces, {0, 1, 2}, {1, 1.0 / 9.80, 1}));
  EXPECT_EQ(name_in(in_g, "channel_unit_mistaken", "channel"), "accelerometer_y");
  EXPECT_EQ(name_in(in_g, "channel_unit_mistaken", "read_as"), "m/s^2");
  const auto degrees = about(Kind::gyro, faces, shown_by(faces, {0, 1, 2}, {1, 1, 57.3}));
  EXPECT_EQ(name_in(degrees, "channel_unit_mistaken", "channel"), "gyro_z");
  EXPECT_EQ(name_in(degrees, "channel_unit_mistaken", "unit"), "deg/s");
}

TEST(AxesCheck, NamesTheSignOfGravityAndUnits) {
  const auto sign = about(Kind::accelerometer, faces, shown_by(faces, {0, 1, 2}, {-1, -1, -1}));
  ASSERT_EQ(sign.size(), 1u);
  EXPECT_EQ(sign[0].code, "gravity_inverted");
  const double g = 9.80665;
  const auto unit = about(Kind::accelerometer, faces, shown_by(faces, {0, 1, 2}, {1 / g, 1 / g, 1 / g}));
  EXPECT_EQ(name_in(unit, "unit_mistaken", "unit"), "g");
  EXPECT_EQ(name_in(unit, "unit_mistaken", "read_as"), "m/s^2");
  const auto rate = about(Kind::gyro, faces, shown_by(faces, {0, 1, 2}, {57.3, 57.3, 57.3}));
  EXPECT_EQ(name_in(rate, "unit_mistaken", "unit"), "deg/s");
  EXPECT_EQ(name_in(rate, "unit_mistaken", "read_as"), "rad/s");
}

TEST(AxesCheck, NamesPositionsInAnotherOrder) {
  auto shown = shown_by(faces, {0, 1, 2}, {1, 1, 1});
  std::swap(shown[0], shown[4]);
  const auto two = about(Kind::accelerometer, faces, shown);
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(name_in({two[0]}, "segment_reads_as_another", "segment"), "z up");
  EXPECT_EQ(name_in({two[0]}, "segment_reads_as_another", "other"), "x up");
  EXPECT_EQ(name_in({two[1]}, "segment_reads_as_another", "segment"), "x up");
  EXPECT_EQ(name_in({two[1]}, "segment_reads_as_another", "other"), "z up");
  // all six in another order, which no exchange of axes explains
  const auto order = shown_by({faces[2], faces[4], faces[1], faces[5], faces[3], faces[0]}, {0, 1, 2}, {1, 1, 1});
  const auto all = about(Kind::accelerometer, faces, order);
  ASSERT_FALSE(all.empty());
  EXPECT_EQ(name_in({all[0]}, "segment_reads_as_another", "other"), "y up");
}

TEST(AxesCheck, AnAxisWithoutInputKeepsItsName) {
  const std::vector<Vector3> about_z{{0, 0, 1}, {0, 0, -1}};
  const auto axes = axes_seen(about_z, shown_by(about_z, {0, 1, 2}, {1, 1, -1}));
  EXPECT_EQ(axes.along, (std::array<std::size_t, 3>{0, 1, 2}));
  EXPECT_LT(axes.ratio[2], 0.0);
  EXPECT_TRUE(std::isnan(axes.ratio[0]));
}

TEST(AxesCheck, ReadsAMatrix) {
  Matrix response(3, 3);
  response(0, 1) = -0.98;
  response(1, 0) = 1.01;
  response(2, 2) = 1.0;
  response(0, 0) = 0.03;
  const auto axes = axes_seen(response);
  EXPECT_EQ(axes.along, (std::array<std::size_t, 3>{1, 0, 2}));
  EXPECT_EQ(about_axes(Kind::gyro, axes).size(), 1u);
}

}  // namespace
}  // namespace tumble::imu
