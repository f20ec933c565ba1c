// Results of before the member `models`: the models that are read from them are those that an identification writes.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tumble/math/symmetric_factor.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/report/report.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

const fs::path folder = fs::path(TUMBLE_SOURCE_DIR) / "tests/reference/results_before";

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

class LegacyResults : public ::testing::TestWithParam<std::string> {
 protected:
  Estimate estimate() const {
    return estimate_from_json(text_of(folder / (GetParam() + ".json")), GetParam() + ".json");
  }
};

TEST_P(LegacyResults, HaveAModelForEachOutput) {
  const Estimate before = estimate();
  ASSERT_FALSE(before.models.empty());
  for (const OutputModel& model : before.models) {
    EXPECT_TRUE(!model.terms.empty() || model.scale) << model.role;
    for (const ModelTerm& term : model.terms) {
      if (!term.parameter) continue;
      EXPECT_EQ(before.parameters[*term.parameter].name, term.term);
      EXPECT_FALSE(term.regressor.empty()) << term.term;
    }
  }
}

TEST_P(LegacyResults, AreTheSameWhenTheyAreWrittenAgain) {
  Estimate before = estimate();
  before.budget = {{"all", "", symmetric_factor(before.covariance).factor}};  // the files are shortened to one source
  const Estimate after = estimate_from_json(to_json(before), "again.json");
  ASSERT_EQ(after.models.size(), before.models.size());
  for (std::size_t m = 0; m < after.models.size(); ++m) {
    const OutputModel &a = after.models[m], &b = before.models[m];
    EXPECT_EQ(a.role, b.role);
    EXPECT_EQ(a.shows, b.shows);
    EXPECT_EQ(a.scale, b.scale);
    EXPECT_EQ(a.offset, b.offset);
    EXPECT_EQ(a.spread, b.spread);
    EXPECT_EQ(a.nominal, b.nominal);
    EXPECT_EQ(a.recorded.dimension(), b.recorded.dimension());
    EXPECT_EQ(a.by_output, b.by_output);
    ASSERT_EQ(a.terms.size(), b.terms.size());
    for (std::size_t t = 0; t < a.terms.size(); ++t) {
      EXPECT_EQ(a.terms[t].parameter, b.terms[t].parameter);
      EXPECT_EQ(a.terms[t].regressor, b.terms[t].regressor) << a.terms[t].term;
      EXPECT_EQ(a.terms[t].per_output, b.terms[t].per_output);
      EXPECT_EQ(a.terms[t].remains, b.terms[t].remains);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, LegacyResults,
                         ::testing::Values("accelerometer_centrifuge", "accelerometer_dynamic",
                                           "accelerometer_four_position", "accelerometer_tumble", "dtg_centrifuge",
                                           "fog_thermal_bias", "gyro_scale_factor", "imu_channel_calibration",
                                           "imu_ferraris", "imu_multi_position", "imu_turntable_short",
                                           "rlg_north_finder", "sdof_gyro_dynamic", "sdof_gyro_static", "static_bias"),
                         [](const auto& entry) { return entry.param; });

}  // namespace
}  // namespace tumble
