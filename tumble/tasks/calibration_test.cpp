#include "tumble/tasks/calibration.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/provenance.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

class CalibrationFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() / (std::string("calibration_") + test->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }

  /// A result with two correlated parameters.
  std::string result(const std::string& serial) const {
    Estimate estimate;
    estimate.method = "rlg_north_finder";
    estimate.instrument_serial = serial;
    estimate.parameters = {{"gyro.scale_factor", "K", Unit::parse("pulse/arcsec"), 91237.4, ""},
                           {"gyro.bias", "B", Unit::parse("deg/h"), 1e-7, ""}};
    estimate.covariance = Matrix(2, 2);
    estimate.covariance(0, 0) = 4.0;
    estimate.covariance(1, 1) = 1e-16;
    estimate.covariance(0, 1) = estimate.covariance(1, 0) = 1e-8;
    settle(estimate, {from_covariance("output noise", estimate.covariance)});
    return write("result.json", to_json(estimate));
  }

  static Refused refusal(Plan plan) {
    return refusal_of([&] { read_calibration(plan); });
  }

  static Plan plan_with(const std::string& file) {
    Plan plan;
    plan.file = "plan.toml";
    plan.instrument_serial = "7";
    plan.calibration.file = file;
    return plan;
  }

  std::filesystem::path folder_;
};

TEST_F(CalibrationFile, IsReadWithItsCovarianceAndChecksum) {
  Plan plan = plan_with(result("7"));
  read_calibration(plan);
  ASSERT_TRUE(plan.calibration.result);
  const auto& covariance = plan.calibration.result->covariance;
  EXPECT_NEAR(covariance(0, 1), 1e-8, 1e-20);
  EXPECT_EQ(plan.calibration.sha256, sha256_of(read_text_file(plan.calibration.file)));
  const Provenance provenance = provenance_of(plan);
  ASSERT_EQ(provenance.inputs.size(), 1u);
  EXPECT_EQ(provenance.inputs[0].sha256, plan.calibration.sha256);
  EXPECT_EQ(provenance.settings.at("calibration"), relative_to(plan, plan.calibration.file));
}

TEST_F(CalibrationFile, APlanWithoutOneIsLeftAlone) {
  Plan plan = plan_with("");
  read_calibration(plan);
  EXPECT_FALSE(plan.calibration.result);
  const Provenance provenance = provenance_of(plan);
  EXPECT_TRUE(provenance.inputs.empty());
}

TEST_F(CalibrationFile, WhatIsNoResultOfThisInstrumentIsRefused) {
  const auto absent = refusal(plan_with((folder_ / "absent.json").string()));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"plan.toml"}, .part = "absent.json"}, absent));
  const auto other = refusal(plan_with(write("other.json", "{\"title\": 1}")));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "tumble identify"}, other));
  const auto serial = refusal(plan_with(result("8")));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"plan.toml", "8", "7"}}, serial));
  EXPECT_TRUE(refusal(plan_with(result(""))).empty());
}

TEST_F(CalibrationFile, AMethodThatBuildsOnNoneRefusesIt) {
  const auto plan = write("plan.toml", "method = \"static_bias\"\ncalibration = \"result.json\"\n");
  const auto refused = refusal_of([&] { load_plan(plan, {}); });
  ASSERT_EQ(refused.problems.size(), 1u);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.part = "static_bias", .key = "calibration", .line = 2}, refused));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.part = "static_bias"}, [] {
    plan_for_method("static_bias", {{"calibration", "result.json"}});
  }));
}

}  // namespace
}  // namespace tumble
