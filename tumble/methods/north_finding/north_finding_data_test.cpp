#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/real_data.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"

namespace tumble {
namespace {

/// Ten readings at each angle of a table whose zero, sense and azimuth are unknown, of a gyro with unknown scale
/// factor; see docs/methods/north_finding.md.
TEST(NorthFindingRealData, AgreesWithPlainLeastSquares) {
  const Method& method = find_method("north_finding");
  const double degree = si(1.0, "deg");
  for (const auto& [name, angles] : {std::pair{"res_15deg.csv", 25}, {"res_45deg.csv", 9}}) {
    const std::string file_name = std::string("alice_fog_north/") + name;
    if (const auto sentence = absent({file_name}); !sentence.empty()) GTEST_SKIP() << sentence;
    std::ifstream file(real_data(file_name));
    Plan plan = trial_plan("north_finding", method.options(), "imu", "rate_table", 0.152);
    plan.site->latitude = 38.0 * degree;
    plan.settings.set_number("settling", 0.0, Unit::parse("s"));
    plan.settings.set_number("averaging", 6.6, Unit::parse("s"));
    Recording recording;
    Channel gyro{"gyro", QuantityKind::other, Unit::parse("V"), {}, {}};
    auto stamps = std::make_shared<std::vector<double>>();
    std::string angle, volts, counter, time;
    while (std::getline(file, angle, ',') && std::getline(file, volts, ',') && std::getline(file, counter, ',') &&
           std::getline(file, time)) {
      const double at = std::stod(angle);
      const std::string label = std::to_string(at);
      if (recording.marks.empty() || recording.marks.back().label != label) {
        recording.marks.push_back({label, std::stod(time), 1});
        const Motion motion{.kind = Motion::Kind::slew, .value = si(30.0, "deg/s"), .to = at * degree};
        plan.schedule.push_back({label, 75.0, 1, {{"table", motion}}});
      }
      gyro.values.push_back(std::stod(volts));
      stamps->push_back(std::stod(time));
    }
    gyro.timeline.stamps = stamps;
    recording.channels = {gyro};
    EXPECT_EQ(recording.marks.size(), static_cast<std::size_t>(angles));
    const auto estimate = method.identify({plan, {recording}}, {});
    const auto* azimuth = find_parameter(estimate, "azimuth");
    ASSERT_NE(azimuth, nullptr);
    // Both are what plain least squares on cos, sin, 1 and t of the means gives: 173.5 and 190.0 deg; its own standard
    // uncertainty is 12 and 7 deg, as if the residuals were independent of each other.
    EXPECT_NEAR(azimuth->value / degree, angles == 25 ? 173.5 : 190.0, 5.0);
    const auto index = static_cast<std::size_t>(azimuth - estimate.parameters.data());
    EXPECT_GT(standard_uncertainty(estimate, index) / degree, 6.0);
    EXPECT_LT(standard_uncertainty(estimate, index) / degree, 25.0);
  }
}

}  // namespace
}  // namespace tumble
