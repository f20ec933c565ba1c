#include <gtest/gtest.h>

#include "tumble/exchange/testing/consumers.hpp"
#include "tumble/exchange/testing/file_numbers.hpp"

namespace tumble::testing {
namespace {

/// Rotation of the first three rows of T_i_b.
Matrix3 rotation_after(const std::string& text) {
  const auto n = numbers_after(text, "T_i_b:", 16);
  EXPECT_EQ(n[3], 0.0);
  EXPECT_EQ(n[15], 1.0);
  return {{n[0], n[1], n[2]}, {n[4], n[5], n[6]}, {n[8], n[9], n[10]}};
}

/// The biases that the consumer estimates: the file states them in its header.
Vector3 bias_in(const std::string& file, const std::string& term) {
  return file.find(term + ":") == std::string::npos ? Vector3{} : vector_after(file, term + ":");
}

void expect_lower(const Matrix3& m) {
  EXPECT_EQ(m(0, 1), 0.0);
  EXPECT_EQ(m(0, 2), 0.0);
  EXPECT_EQ(m(1, 2), 0.0);
}

}  // namespace

/// ImuParameters of IccSensors.py: a_m = M_a a + b_a, w_m = M_g C w + A C a + b_g.
Consumed kalibr(const std::string& file, const ImuSample& raw) {
  const std::string text = without_comments(file, "#");
  const std::string of_gyros = text.substr(text.find("gyroscopes:"));
  const Matrix3 body = transposed(rotation_after(text)), m_a = matrix_after(text, "M:"),
                a = matrix_after(of_gyros, "A:"), c = matrix_after(of_gyros, "C_gyro_i:"),
                m_g = matrix_after(of_gyros, "M:");
  expect_lower(m_a);
  expect_lower(m_g);
  const Vector3 force = inverse(m_a) * (raw.force - bias_in(file, "accelerometer_bias"));
  const Vector3 rate = transposed(c) * (inverse(m_g) * (raw.rate - bias_in(file, "gyro_bias") - a * (c * force)));
  Consumed out{raw};
  out.sample.force = body * force;
  out.sample.rate = body * rate;
  return out;
}

/// Propagator.cpp: a = R_IMUtoACC' Da (a_m - b_a), w = R_IMUtoGYRO' Dw (w_m - b_g - Tg a), with D = inv(T) of which one
/// triangle is kept.
Consumed openvins(const std::string& file, const ImuSample& raw, bool wrong) {
  EXPECT_TRUE(file.starts_with("%YAML:1.0\n"));
  const std::string text = without_comments(file, "#");
  const Matrix3 body = transposed(rotation_after(text)), r_gyro = matrix_after(text, "R_IMUtoGYRO:"),
                r_acc = matrix_after(text, "R_IMUtoACC:");
  Matrix3 da = inverse(matrix_after(text, "Ta:")), dw = inverse(matrix_after(text, "Tw:")),
          tg = matrix_after(text, "Tg:");
  if (wrong) tg = tg * transposed(r_gyro);  // A = Tg C_gyro_i'
  const bool kalibr_model = text.find("model: \"kalibr\"") != std::string::npos;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (kalibr_model ? j > i : j < i) da(i, j) = dw(i, j) = 0.0;
  const Vector3 force = transposed(r_acc) * (da * (raw.force - bias_in(file, "accelerometer_bias")));
  const Vector3 rate = transposed(r_gyro) * (dw * (raw.rate - bias_in(file, "gyro_bias") - tg * force));
  Consumed out{raw};
  out.sample.force = body * force;
  out.sample.rate = body * rate;
  return out;
}

}  // namespace tumble::testing
