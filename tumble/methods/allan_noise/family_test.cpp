#include "tumble/methods/allan_noise/family.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "tumble/math/noise_model.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/noise_record.hpp"
#include "tumble/units/error.hpp"

namespace tumble::allan_noise {
namespace {

/// White noise of 1 deg/h a sample at 10 Hz.
Evidence gyro(const std::string& deviations, double gap_share) {
  Channel channel{"gyro.x", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, 10.0, nullptr}, {}};
  channel.values.assign(3000, 0.0);
  add_noise({.angle_random_walk = si(1.0, "deg/h") / std::sqrt(10.0)}, 10.0, RandomStream(12), channel.values);
  for (std::size_t i = 0; static_cast<double>(i) < gap_share * 3000.0; ++i)
    channel.values[1 + 2 * i] = std::numeric_limits<double>::quiet_NaN();
  Evidence evidence = noise_evidence({std::move(channel)});
  if (!deviations.empty()) evidence.plan.settings.set_word("deviations", deviations);
  return evidence;
}

TEST(NoiseFamily, GivesWhatIsAskedForAndNoMore) {
  EXPECT_EQ(find_table(identify_noise(gyro("", 0.0)), "family"), nullptr);
  const auto estimate = identify_noise(gyro("[mdev, \"htotdev\"]", 0.0));
  const Table* table = find_table(estimate, "family");
  ASSERT_NE(table, nullptr);
  std::set<std::string> names, curves;
  for (const auto& row : table->rows) names.insert(std::get<std::string>(row[1]));
  for (const auto& curve : estimate.curves)
    if (curve.figure == "family of deviations gyro.x") curves.insert(curve.name);
  EXPECT_EQ(names, (std::set<std::string>{"mdev", "htotdev"}));
  EXPECT_EQ(curves, (std::set<std::string>{"gyro.x oadev", "gyro.x mdev", "gyro.x htotdev"}));
}

// White noise has the deviation 1/sqrt(m) deg/h at m = 4, edf above 400: 4 sd of the deviation are 0.14 of it. Its
// modified Allan variance is (m^2 + 1/2)/(m^2) of half that, the time deviation tau/sqrt(3) times the modified one:
// 0.4 s * 0.359 deg/h / sqrt(3) in arcsec is the same number.
TEST(NoiseFamily, HasTheUnitsOfEach) {
  const auto estimate = identify_noise(gyro("all", 0.0));
  const Table* table = find_table(estimate, "family");
  ASSERT_NE(table, nullptr);
  std::set<std::string> names;
  for (const auto& row : table->rows) {
    const auto text = [&](std::size_t k) { return std::get<std::string>(row[k]); };
    names.insert(text(1));
    const double at = std::get<double>(row[2]);
    if (at < 0.39 || at > 0.41) continue;
    const double modified = 0.5 * std::sqrt((16.0 + 0.5) / 32.0);
    if (text(1) == "ohdev" || text(1) == "totdev") {
      EXPECT_NEAR(std::stod(text(3)), 0.5, 0.07) << text(1);
      EXPECT_EQ(text(5), "deg/h");
    }
    if (text(1) == "mdev") {
      EXPECT_NEAR(std::stod(text(3)), modified, 0.2 * modified);
    }
    if (text(1) == "tdev") {
      EXPECT_NEAR(std::stod(text(3)), 0.4 * modified / std::sqrt(3.0), 0.05 * modified);
      EXPECT_EQ(text(5), "arcsec");
    }
    EXPECT_EQ(text(7), "white rate");
    if (text(1) == "mtie") {
      EXPECT_EQ(text(4), "none known");
    }
  }
  EXPECT_EQ(names.size(), 15u);
}

TEST(NoiseFamily, SaysWhereGapsPreventAMeasure) {
  EXPECT_EQ(finding_of(identify_noise(gyro("theo1", 0.45)).findings, "no_averaging_time_between_gaps"), nullptr);
  Evidence broken = gyro("theo1", 0.0);
  auto& values = broken.recordings[0].channels[0].values;
  for (std::size_t i = 0; i < values.size(); i += 5) values[i] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(has_finding(identify_noise(broken).findings, "no_averaging_time_between_gaps", {{"deviation", "theo1"}}));
}

TEST(NoiseFamily, NamesEveryWordItDoesNotKnow) {
  const std::vector<Asked> both{{.values = {"ohdve", "ohdev"}}, {.values = {"sigma"}}};
  EXPECT_TRUE(refuses(Error::Kind::bad_input, both, [] { identify_noise(gyro("ohdve, totdev, sigma", 0.0)); }));
}

}  // namespace
}  // namespace tumble::allan_noise
