// The stations that travel with the program carry out the plans that they are made for, and one plan gives the same
// answer at controllers that speak unlike protocols.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

const std::string root = TUMBLE_SOURCE_DIR "/";

struct Value {
  double value = 0.0, sd = 0.0;
};

Value value_of(const Estimate& estimate, const std::string& name) {
  const auto found = std::ranges::find(estimate.parameters, name, &Parameter::name);
  EXPECT_NE(found, estimate.parameters.end()) << name;
  if (found == estimate.parameters.end()) return {};
  const auto index = static_cast<std::size_t>(found - estimate.parameters.begin());
  return {found->value, std::sqrt(estimate.covariance(index, index))};
}

/// The plan carried out at this station, and what its method finds.
Estimate found_at(const std::string& plan, const std::string& station, std::uint64_t seed = 1) {
  const ScratchFolder scratch;
  Rehearsal rehearsal;
  rehearsal.plan = load_plan(root + "plans/" + plan + ".toml", {});
  rehearsal.station = load_station(station);
  rehearsal.seed = seed;
  rehearsal.folder = scratch.file("run");
  rehearsal.recording = scratch.file("run.h5");
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
  return identify(rehearsal.plan, {rehearsal.recording}, std::size_t{1} << 30, {});
}

/// What the plan's truth makes of each parameter is what its prediction states.
struct Ready {
  const char* plan;
  std::vector<std::string> parameters;
};

class ReadyStation : public ::testing::TestWithParam<Ready> {};

TEST_P(ReadyStation, CarriesItsPlanOutAndTheTruthIsFound) {
  const auto& [name, parameters] = GetParam();
  const Estimate found = found_at(name, root + "stations/" + name + ".toml");
  const Estimate truth = predict(load_plan(root + "plans/" + name + ".toml", {}));
  for (const auto& parameter : parameters) {
    const Value value = value_of(found, parameter);
    EXPECT_GT(value.sd, 0.0) << parameter;
    EXPECT_NEAR(value.value, value_of(truth, parameter).value, 4.0 * value.sd) << parameter;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Stations, ReadyStation,
    ::testing::Values(Ready{"sdof_gyro_static", {"D_F", "D_I", "D_O", "D_S", "D_IO", "D_OS", "D_IS", "D_II", "D_SS"}},
                      Ready{"accelerometer_tumble",
                            {"bias", "scale_factor", "second_order_coefficient", "cross_coupling_ip", "misalignment_o",
                             "misalignment_p"}},
                      Ready{"gyro_scale_factor", {"bias", "scale_factor_asymmetry", "third_order_coefficient"}},
                      Ready{"rlg_north_finder",
                            {"gyro.scale_factor", "gyro.bias", "accelerometer_x.bias", "accelerometer_x.misalignment_y",
                             "accelerometer_y.scale_factor", "accelerometer_y.bias"}}),
    [](const auto& one) { return std::string(one.param.plan); });

TEST(ReadyStations, ThreeAccelerometersOnTheShakerShowTheirRectification) {
  const Estimate found = found_at("sine_vibration", root + "stations/sine_vibration.toml");
  const double unit = 1e-6 / 9.80665;
  for (const auto& [name, truth] : {std::pair{"S1", 20.0}, std::pair{"S2", 25.0}, std::pair{"S3", 15.0}}) {
    const Value value = value_of(found, std::string(name) + ".vibration_rectification");
    EXPECT_NEAR(value.value, truth * unit, 4.0 * value.sd) << name;
  }
}

/// Long: five hours and a half of a centrifuge at 50 Hz.
TEST(ReadyStationsCoverage, ATunedGyroOnTheCentrifugeShowsItsTerms) {
  const Estimate found = found_at("dtg_centrifuge", root + "stations/dtg_centrifuge.toml");
  const double unit = degree / 3600.0 / 9.80665;  // deg/h/g
  // with the spin axis up D_x means D_x + D_xz g, and D_y means D_y + D_yz g
  for (const auto& [name, truth] : {std::pair{"D_x", 6.0 + 0.15}, std::pair{"D_y", -2.5 - 0.05}}) {
    const Value value = value_of(found, name);
    EXPECT_NEAR(value.value, truth * unit, 4.0 * value.sd) << name;
  }
}

/// A shipped station with another controller in place of its first one.
std::string with_controller(const ScratchFolder& scratch, const std::string& station, const std::string& controller) {
  std::string text = read_text_file(root + "stations/" + station + ".toml");
  const auto replace = [&](const std::string& key, const std::string& value) {
    const auto line = text.find("\n" + key);
    ASSERT_NE(line, std::string::npos) << key;
    text.replace(line + 1, text.find('\n', line + 1) - line - 1, value.empty() ? "" : key + " = \"" + value + '"');
  };
  replace("controller", controller);
  replace("frames", root + "stations/frames/" + station + ".toml");
  if (text.find("\ntimeouts") != std::string::npos) replace("timeouts", "");
  if (controller == "atl_like") replace("speed", "");  // its position takes none
  const std::string path = scratch.file(station + "_" + controller + ".toml");
  std::ofstream(path) << text;
  return path;
}

/// Each bench has noise and errors of its own.
void expect_agreement(const std::string& plan, const std::string& parameter,
                      const std::vector<std::string>& controllers) {
  const ScratchFolder scratch;
  std::vector<Value> values;
  for (const auto& controller : controllers)
    values.push_back(
        value_of(found_at(plan, with_controller(scratch, plan, controller), values.size() + 1), parameter));
  for (std::size_t i = 0; i < values.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      EXPECT_NEAR(values[i].value, values[k].value, 4.0 * std::hypot(values[i].sd, values[k].sd))
          << controllers[i] << " and " << controllers[k];
}

TEST(ReadyStations, APlanOfPositionsAgreesOnFourUnlikeProtocols) {
  expect_agreement("accelerometer_tumble", "bias", {"newport_smc100", "pi_gcs", "aerotech_ensemble", "scpi_like"});
}

TEST(ReadyStations, APlanOfPositionsAgreesOnFourLikeTablesOfLaboratories) {
  expect_agreement("accelerometer_tumble", "bias", {"acutrol_like", "atl_like", "mn_three_axis", "grbl"});
}

TEST(ReadyStations, APlanOfRatesAgreesOnThreeUnlikeProtocols) {
  expect_agreement("gyro_scale_factor", "scale_factor", {"acutrol_like", "scpi_like", "aerotech_ensemble"});
}

}  // namespace
}  // namespace tumble
