#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tumble/formats/format.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

Estimate identified(const Evidence& evidence) { return find_method("imu_ferraris").identify(evidence, {}); }

double cell(const Estimate& estimate, const std::string& matrix, std::size_t row, std::size_t column) {
  std::size_t seen = 0;
  for (const auto& cells : find_table(estimate, "matrices")->rows)
    if (std::get<std::string>(cells[0]) == matrix && seen++ == row) return std::get<double>(cells[3 + column]);
  ADD_FAILURE() << "no " << matrix;
  return std::nan("");
}

/// The published session as a user would read it.
Evidence published(const std::string& angle) {
  const std::string folder = TUMBLE_SOURCE_DIR "/tests/reference/imucal/";
  ReadOptions options;
  options.rate = 204.8;
  options.segment_column = "part";
  options.columns = {"part", "-"};
  for (const char* name : {"accelerometer_x", "accelerometer_y", "accelerometer_z", "gyro_x", "gyro_y", "gyro_z"})
    options.columns.push_back(std::string(name) + "[LSB]");
  Evidence evidence;
  Problems problems;
  evidence.plan.settings = resolve(find_method("imu_ferraris").options(),
                                   {{"gravity", "9.81 m/s^2", "", true, true},
                                    {"rotation_angle", angle, "", true, true},
                                    {"axes", "any", "", true, true}},
                                   "", problems);
  evidence.recordings = {read_recording(folder + "annotated_session.csv", options, {})};
  return evidence;
}

TEST(ImuFerrarisPublished, Agrees) {
  const auto estimate = identified(published("-360 deg"));
  const auto expected = nlohmann::json::parse(
      std::ifstream(TUMBLE_SOURCE_DIR "/tests/reference/imucal/annotated_session_expected_cal.json"));
  for (const char* matrix : {"K_a", "R_a", "K_g", "R_g", "K_ga"})
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        EXPECT_NEAR(cell(estimate, matrix, i, j), expected[matrix][i][j].get<double>(), 1e-10) << matrix << i << j;
  for (const char* vector : {"b_a", "b_g"})
    for (std::size_t j = 0; j < 3; ++j)
      EXPECT_NEAR(cell(estimate, vector, 0, j), expected[vector][j].get<double>(), 1e-10) << vector << j;
  EXPECT_TRUE(has_finding(estimate.findings, "rates_inverted"));
}

TEST(ImuFerrarisPublished, CompensatesThePosesToGravityAndTheTurnsToTheAngle) {
  const auto evidence = published("360 deg");
  auto estimate = identified(evidence);
  const auto out = compensate(estimate, evidence.recordings[0], nullptr).recording;
  Evidence again = evidence;
  again.recordings = {out};
  const auto unit = identified(again);
  // what is left of the biases: the poses lean by less than 1 deg across axes that lean by less than 2.5 deg, in each
  // of which a bias is read from two poses alone; and of that what the gyros make of specific force
  // Compensated by the parameters, from which the mean cosine of tilts of 0.42 deg is subtracted: half their square,
  // which the closed form then finds again; and that share of some 0.01 deg/s/g.
  const double cosine = 1.0 - 0.5 * std::pow(si(0.42, "deg"), 2);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(cell(unit, "K_a", i, i), cosine, 5e-7);
    EXPECT_NEAR(cell(unit, "b_a", 0, i), 0.0, 0.0175 * 0.044 * 9.81);
    EXPECT_NEAR(cell(unit, "K_g", i, i), 1.0, 1e-5);
    EXPECT_NEAR(cell(unit, "R_g", i, (i + 1) % 3), 0.0, 1e-5);
    EXPECT_NEAR(cell(unit, "K_ga", i, 0), 0.0, 0.01 * (1.0 - cosine));
  }
  const auto* sd = find_channel(out, "gyro_x.compensation_sd");
  ASSERT_NE(sd, nullptr);
  EXPECT_GT(sd->values[0], 0.0);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "compensated already"},
                      [&] { compensate(estimate, out, nullptr); }));  // not twice
}

}  // namespace
}  // namespace tumble
