#include "tumble/exchange/testing/consumers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/exchange/testing/file_numbers.hpp"

namespace tumble::testing {
namespace {

constexpr const char* axes[] = {"X", "Y", "Z"};

/// A parameter of a list "name<separator>value"; `otherwise` where the vehicle keeps its default.
double parameter(const std::string& text, const std::string& name, char separator, double otherwise) {
  const std::string key = name + separator;
  return text.find(key) == std::string::npos ? otherwise : number_after(text, key);
}

/// TemperatureCompensation.cpp: offset = X0 + X1 d + X2 d^2 + X3 d^3 in floats, where it is enabled.
double px4_thermal(const std::string& text, char letter, std::size_t axis, double kelvin) {
  const std::string prefix = std::string("TC_") + letter + "0_";
  if (parameter(text, std::string("TC_") + letter + "_ENABLE", '\t', 0.0) != 1.0) return 0.0;
  const double celsius = std::clamp(kelvin - 273.15, parameter(text, prefix + "TMIN", '\t', 0.0),
                                    parameter(text, prefix + "TMAX", '\t', 100.0));
  const double d = celsius - parameter(text, prefix + "TREF", '\t', 40.0);
  double sum = 0.0;
  for (int power = 3; power >= 0; --power)
    sum = sum * d + parameter(text, prefix + "X" + std::to_string(power) + "_" + std::to_string(axis), '\t', 0.0);
  return sum;
}

/// AP_InertialSensor_tempcal.cpp: v -= P(T) - P(CALTEMP).
double ardupilot_thermal(const std::string& text, const std::string& kind, std::size_t axis, double kelvin) {
  if (parameter(text, "INS_TCAL1_ENABLE", ',', 0.0) != 1.0) return 0.0;
  const auto polynomial = [&](double celsius) {
    const double d =
        std::clamp(celsius, parameter(text, "INS_TCAL1_TMIN", ',', 0.0), parameter(text, "INS_TCAL1_TMAX", ',', 70.0)) -
        35.0;
    const auto c = [&](int power) {
      return parameter(text, "INS_TCAL1_" + kind + std::to_string(power) + "_" + axes[axis], ',', 0.0);
    };
    return (c(1) + (c(2) + c(3) * d) * d) * d * 1e-6;
  };
  return polynomial(kelvin - 273.15) - polynomial(parameter(text, "INS_" + kind + "1_CALTEMP", ',', -300.0));
}

}  // namespace

/// sensor_calibration/Accelerometer.hpp, Gyroscope.hpp: (data - thermal - offset) .* scale; of gyros without the scale.
Consumed px4(const std::string& file, const ImuSample& raw) {
  const std::string text = without_comments(file, "#");
  Consumed out{raw};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string axis = axes[i];
    out.sample.force[i] = (raw.force[i] - px4_thermal(text, 'A', i, raw.temperature) -
                           parameter(text, "CAL_ACC0_" + axis + "OFF", '\t', 0.0)) *
                          parameter(text, "CAL_ACC0_" + axis + "SCALE", '\t', 1.0);
    out.sample.rate[i] = raw.rate[i] - px4_thermal(text, 'G', i, raw.temperature) -
                         parameter(text, "CAL_GYRO0_" + axis + "OFF", '\t', 0.0);
  }
  return out;
}

/// AP_InertialSensor_Backend.cpp: -= tcal, -= offset, *= scale; of gyros the first two.
Consumed ardupilot(const std::string& file, const ImuSample& raw) {
  const std::string text = without_comments(file, "#");
  Consumed out{raw};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string axis = axes[i];
    out.sample.force[i] = (raw.force[i] - ardupilot_thermal(text, "ACC", i, raw.temperature) -
                           parameter(text, "INS_ACCOFFS_" + axis, ',', 0.0)) *
                          parameter(text, "INS_ACCSCAL_" + axis, ',', 1.0);
    out.sample.rate[i] = raw.rate[i] - ardupilot_thermal(text, "GYR", i, raw.temperature) -
                         parameter(text, "INS_GYROFFS_" + axis, ',', 0.0);
  }
  return out;
}

/// calibration.h: the first 21 numbers are T, K and B; X' = T K (X - B).
Consumed imu_tk(const std::string& file, const ImuSample& raw, bool gyros) {
  const auto n = numbers_after(file, "", 21);
  const Matrix3 t{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]}};
  const Matrix3 k{{n[9], n[10], n[11]}, {n[12], n[13], n[14]}, {n[15], n[16], n[17]}};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(t(i, i), 1.0);
  if (!gyros) {
    EXPECT_TRUE(t(1, 0) == 0.0 && t(2, 0) == 0.0 && t(2, 1) == 0.0);
  }
  const Matrix3 back = transposed(matrix_after(file, "# rotation "));
  const Vector3 u = back * (t * (k * ((gyros ? raw.rate : raw.force) - Vector3{n[18], n[19], n[20]})));
  Consumed out{raw, !gyros, gyros};
  (gyros ? out.sample.rate : out.sample.force) = u;
  return out;
}

/// accel_calib.cpp: SM raw - bias.
Consumed ros_imu_calib(const std::string& file, const ImuSample& raw) {
  const std::string text = without_comments(file, "#");
  Consumed out{raw, true, false};
  out.sample.force = matrix_after(text, "SM:") * raw.force - vector_after(text, "bias:");
  return out;
}

/// ferraris_calibration_info.py, in deg/s.
Consumed imucal(const std::string& file, const ImuSample& raw) {
  const double degrees = 180.0 / M_PI;
  Consumed out{raw};
  const Vector3 acc = inverse(matrix_after(file, "\"R_a\":")) *
                      (inverse(matrix_after(file, "\"K_a\":")) * (raw.force - vector_after(file, "\"b_a\":")));
  const Vector3 gyr = inverse(matrix_after(file, "\"R_g\":")) *
                      (inverse(matrix_after(file, "\"K_g\":")) *
                       (degrees * raw.rate - matrix_after(file, "\"K_ga\":") * acc - vector_after(file, "\"b_g\":")));
  out.sample.force = acc;
  out.sample.rate = gyr / degrees;
  return out;
}

/// imuclbt.m by imuadderr.m with the opposite signs: gSens times the accelerations before Ka, then Kg and Ka, then eb
/// and db.
Consumed psins(const std::string& file, const ImuSample& raw) {
  const std::string text = without_comments(file, "%");
  const auto sf = numbers_after(text, "clbt.sf =", 6);
  const Vector3 w = scaled({sf[0], sf[1], sf[2]}, raw.rate), f = scaled({sf[3], sf[4], sf[5]}, raw.force);
  Consumed out{raw};
  out.sample.rate =
      matrix_after(text, "clbt.Kg =") * w - matrix_after(text, "clbt.gSens =") * f - vector_after(text, "clbt.eb =");
  out.sample.force = matrix_after(text, "clbt.Ka =") * f - vector_after(text, "clbt.db =");
  return out;
}

/// Row vectors times the inverse of the transposes.
Consumed matlab(const std::string& file, const ImuSample& raw) {
  const std::string text = without_comments(file, "%");
  Consumed out{raw};
  const Vector3 force = inverse(matrix_after(text, "K_a =")) * (raw.force - vector_after(text, "b_a ="));
  out.sample.force = force;
  out.sample.rate = inverse(matrix_after(text, "K_g =")) *
                    (raw.rate - vector_after(text, "b_g =") - matrix_after(text, "G =") * force);
  return out;
}

}  // namespace tumble::testing
