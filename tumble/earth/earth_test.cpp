#include "tumble/earth/earth.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

namespace tumble {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

std::vector<std::vector<double>> reference(const std::string& file) {
  std::ifstream stream(TUMBLE_SOURCE_DIR "/tests/reference/earth_model/" + file);
  std::vector<std::vector<double>> rows;
  std::string line, cell;
  std::getline(stream, line);
  while (std::getline(stream, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    while (std::getline(cells, cell, ',')) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

// The tolerances are derived in tests/reference/earth_model/SOURCE.md.
TEST(NormalGravity, AgreesWithTheExactFormula) {
  const auto rows = reference("normal_gravity_geographiclib.csv");
  ASSERT_EQ(rows.size(), 119u);
  for (const auto& row : rows) {
    const double h = std::abs(row[1]) / 6378137.0, f = 1 / 298.257;
    const double tolerance = 1e-10 + 9.8 * (10 * f * f * h + 4 * h * h * h);
    EXPECT_NEAR(normal_gravity(row[0] * degree, row[1]), row[2], tolerance) << row[0] << " deg, " << row[1] << " m";
  }
}

TEST(Earth, AgreesWithPyins) {
  const auto rows = reference("pyins_gravity_earthrate.csv");
  ASSERT_EQ(rows.size(), 18u);
  for (const auto& row : rows) {
    Site site;
    site.latitude = row[0] * degree;
    site.height = row[1];
    const Vector3 rate_in_level = earth_rate_in_level(site);
    EXPECT_NEAR(rate_in_level.x, row[4], 1e-16);
    EXPECT_NEAR(rate_in_level.y, row[3], 1e-16);
    EXPECT_NEAR(rate_in_level.z, -row[5], 1e-16);
    if (row[1] == 0.0) {
      EXPECT_NEAR(gravity(site), row[2], 1e-10);
    }
  }
}

TEST(Earth, MeasuredGravityComesFirst) {
  Site site;
  site.latitude = 34.25 * degree;
  site.height = 400.0;
  EXPECT_EQ(gravity(site), normal_gravity(site.latitude, *site.height));
  site.gravity = 9.7966;
  EXPECT_EQ(gravity(site), 9.7966);
}

TEST(Earth, RateIsTheOneOfTheConventions) {
  Site pole;
  pole.latitude = 90 * degree;
  // 15.041067 deg/h, given to 1e-6 deg/h.
  EXPECT_NEAR(earth_rate_in_level(pole).z / degree * 3600, 15.041067, 5e-7);
  EXPECT_DOUBLE_EQ(norm(earth_rate_in_level(pole)), earth_rate);
}

/// A measured gravity, the formula at a height, the formula anywhere on a hill, and anywhere on Earth.
TEST(Earth, GravityIsAsUncertainAsItsOrigin) {
  Site site{.latitude = 34.25 * degree, .height = 400.0, .gravity = 9.7966};
  EXPECT_DOUBLE_EQ(gravity_sd(site), si(5.0, "ug"));
  site.gravity.reset();
  EXPECT_DOUBLE_EQ(gravity_sd(site), si(50.0, "ug"));
  site.height.reset();
  // what 1000 m make of normal gravity, and the anomaly
  const double kilometre = normal_gravity(site.latitude, 0.0) - normal_gravity(site.latitude, 1000.0);
  EXPECT_NEAR(gravity_sd(site), std::hypot(kilometre, si(50.0, "ug")), 1e-3 * kilometre);
  // equator and pole differ by 0.052 m/s^2: as if even, that over sqrt(12)
  EXPECT_NEAR(gravity_sd({}), 0.052 / std::sqrt(12.0), 1e-3);
  EXPECT_DOUBLE_EQ(latitude_sd(site), si(10.0, "arcsec"));
  site.latitude_sd = 1e-4;
  EXPECT_EQ(latitude_sd(site), 1e-4);
}

}  // namespace
}  // namespace tumble
