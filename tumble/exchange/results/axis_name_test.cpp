#include "tumble/exchange/results/axis_name.hpp"

#include <gtest/gtest.h>

namespace tumble::results {
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

}  // namespace
}  // namespace tumble::results
