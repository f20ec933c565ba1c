#include "tumble/core/roles.hpp"

#include <gtest/gtest.h>

namespace tumble {
namespace {

TEST(AxisName, UsualNamesOfChannels) {
  for (const char* name : {"gyro.x",
                           "gyro_x",
                           "ax",
                           "ax_g",
                           "acc_x",
                           "gyro_x_dps",
                           "wx",
                           "GyrX",
                           "accelX",
                           "imu_acc_x",
                           "imu0/angular_velocity.x",
                           "AccX_mps2",
                           "GYRO_X",
                           "omega_x[1]",
                           "xacc",
                           "xgyro",
                           "X-axis",
                           "Gyroscope X (rad/s)",
                           "gyro1x",
                           "wX_b",
                           "imu_2.gx"})
    EXPECT_EQ(axis_named(name), 0u) << name;
  for (const char* name : {"az", "acc_z_mps2", "GyroscopeUncalibrated.z", "yaw_rate_z", "zgyro"})
    EXPECT_EQ(axis_named(name), 2u) << name;
  EXPECT_EQ(axis_named("wy_rad_s"), 1u);
}

TEST(AxisName, ALetterAtTheEndOfAnotherWordIsNoAxis) {
  for (const char* name : {"gyro", "angular_velocity", "gyro_hz", "flux", "gyro_max", "index", "signal", "", "7"})
    EXPECT_FALSE(axis_named(name)) << name;
  EXPECT_FALSE(axis_named("rotation_x_to_y"));
}

TEST(Roles, AnAxisMayFollowADot) {
  EXPECT_EQ(names_of_role("gyro_x"), (std::vector<std::string>{"gyro_x", "gyro.x"}));
  EXPECT_EQ(names_of_role("signal"), (std::vector<std::string>{"signal"}));
  EXPECT_EQ(names_of_role("x"), (std::vector<std::string>{"x"}));
  EXPECT_EQ(names_of_role("_x"), (std::vector<std::string>{"_x"}));
  Recording recording;
  recording.channels.push_back({.name = "gyro.x"});
  EXPECT_EQ(find_role(recording, "gyro_x"), &recording.channels[0]);
  EXPECT_EQ(find_role(recording, "gyro_y"), nullptr);
  recording.channels.push_back({.name = "gyro_x"});
  EXPECT_EQ(find_role(recording, "gyro_x"), &recording.channels[1]) << "its own name comes first";
}

std::string said(const std::vector<NamedKind>& channels) {
  std::string text;
  for (const auto& [role, channel] : proposed_roles(channels)) text += role + "=" + channel + " ";
  return text;
}

TEST(Roles, AreProposedWhereNamesSayTheAxesOnce) {
  const auto rate = QuantityKind::angular_rate, force = QuantityKind::specific_force;
  EXPECT_EQ(said({{"wx", rate}, {"wz", rate}, {"wy", rate}, {"t", QuantityKind::temperature}}),
            "gyro_x=wx gyro_y=wy gyro_z=wz ");
  EXPECT_EQ(said({{"ax", force}, {"ay", force}, {"az", force}, {"wx", rate}}),
            "accelerometer_x=ax accelerometer_y=ay accelerometer_z=az ");
  EXPECT_EQ(said({{"gyro.x", rate}, {"gyro.y", rate}, {"gyro.z", rate}}), "") << "these play their roles already";
  EXPECT_EQ(said({{"ax", force}, {"bx", force}, {"ay", force}, {"az", force}, {"acc_x", force}}), "") << "two may be x";
}

}  // namespace
}  // namespace tumble
