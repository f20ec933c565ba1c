#include "tumble/methods/allan_noise/input.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "tumble/math/noise_model.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/noise_record.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::allan_noise {
namespace {

const std::string stable32 = std::string(TUMBLE_SOURCE_DIR) + "/tests/reference/stable32_phasedat/";

/// Rows of a table of Stable32, by averaging factor: the numbers behind it.
std::map<int, std::vector<double>> table_of(const std::string& name) {
  std::ifstream in(stable32 + name);
  std::map<int, std::vector<double>> rows;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    int factor = 0;
    if (!(words >> factor)) continue;
    std::vector<double> row;
    for (double value = 0.0; words >> value;) row.push_back(value);
    rows[factor] = row;
  }
  return rows;
}

/// PHASE.DAT: 1001 time errors, one a second.
Evidence clock_evidence() {
  Channel channel{"phase", QuantityKind::time, Unit::parse("s"), {0.0, 1.0, nullptr}, {}};
  std::ifstream in(stable32 + "PHASE.DAT");
  for (std::string line; std::getline(in, line);)
    if (!line.empty() && line[0] != '#') channel.values.push_back(std::stod(line));
  Evidence evidence = noise_evidence({channel});
  evidence.plan.settings.set_word("data", "phase");
  return evidence;
}

const Curve& curve_named(const Estimate& estimate, const std::string& name) {
  const auto found = std::ranges::find(estimate.curves, name, &Curve::name);
  if (found == estimate.curves.end()) throw std::runtime_error("no curve " + name);
  return *found;
}

/// A curve at the factors of a table: column `value` of it to 1e-4, limits to 1e-2 where the table has them.
void expect_published(const Curve& curve, const std::string& name, std::size_t value, bool limits) {
  std::size_t compared = 0;
  for (const auto& [factor, row] : table_of(name)) {
    const auto at = std::ranges::find_if(curve.x.values, [&](double tau) { return std::abs(tau - factor) < 1e-6; });
    if (at == curve.x.values.end()) continue;
    const auto i = static_cast<std::size_t>(at - curve.x.values.begin());
    EXPECT_NEAR(curve.y.values[i] / row[value], 1.0, 1e-4) << name << " " << factor;
    if (limits) {
      EXPECT_NEAR(curve.lower[i] / row[value - 1], 1.0, 1e-2) << name << " " << factor;
      EXPECT_NEAR(curve.upper[i] / row[value + 1], 1.0, 1e-2) << name << " " << factor;
    }
    ++compared;
  }
  EXPECT_GE(compared, 5u) << name;
}

TEST(NoiseInput, PhaseAtOctavesGivesTheTablesOfStable32) {
  Evidence evidence = clock_evidence();
  evidence.plan.settings.set_word("taus", "octave");
  evidence.plan.settings.set_word("deviations", "totdev, mdev, ohdev, mtotdev");
  evidence.plan.settings.set_word("total_bias", "keep");
  evidence.plan.settings.set_number("confidence", 0.683, Unit());
  const auto estimate = identify_noise(evidence);
  EXPECT_NE(find_parameter(estimate, "phase.white_frequency_noise"), nullptr);
  // Columns behind the factor: tau, number, noise type, least, value, greatest. Limits at the confidence asked for.
  expect_published(curve_named(estimate, "phase oadev"), "phase_dat_oadev_octave.txt", 4, true);
  expect_published(curve_named(estimate, "phase mdev"), "phase_dat_mdev_octave.txt", 4, false);
  expect_published(curve_named(estimate, "phase ohdev"), "phase_dat_ohdev_octave.txt", 4, false);
  expect_published(curve_named(estimate, "phase totdev"), "phase_dat_totdev_octave.txt", 4, false);
  expect_published(curve_named(estimate, "phase mtotdev"), "phase_dat_mtotdev_octave.txt", 4, false);
}

TEST(NoiseInput, AListOfTimesGivesTheIntervalErrorsOfStable32) {
  Evidence evidence = clock_evidence();
  evidence.plan.settings.set_word("taus", "[1 s, 3, 7 s, 15, 31, 63, 127]");
  evidence.plan.settings.set_word("deviations", "mtie, tierms");
  evidence.plan.settings.set_word("mean_rate", "keep");
  const auto estimate = identify_noise(evidence);
  const Curve& curve = curve_named(estimate, "phase mtie");
  EXPECT_EQ(curve.x.values.size(), 7u);
  expect_published(curve, "phase_dat_mtie.txt", 2, false);
}

/// The published deviation of nist1000 that `measure` has at this time.
double published(const std::string& measure, double tau) {
  std::ifstream in(std::string(TUMBLE_SOURCE_DIR) + "/tests/reference/nist1000/published.txt");
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string name;
    double time = 0.0, value = 0.0;
    if (words >> name >> time >> value && name == measure && time == tau) return value;
  }
  throw std::runtime_error("no published " + measure);
}

TEST(NoiseInput, EveryKindOfDataGivesThePublishedDeviationsOfNist1000) {
  std::vector<double> values, sums{0.0};
  std::ifstream in(std::string(TUMBLE_SOURCE_DIR) + "/tests/reference/nist1000/nist1000_freq.csv");
  for (std::string line; std::getline(in, line);)
    if (!line.empty() && line[0] != '#') values.push_back(std::stod(line));
  ASSERT_EQ(values.size(), 1000u);
  for (const double value : values) sums.push_back(sums.back() + value);
  const auto expect = [&](QuantityKind kind, const char* unit, const std::vector<double>& given, const char* data) {
    Evidence evidence = noise_evidence({{"x", kind, Unit::parse(unit), {0.0, 1.0, nullptr}, given}});
    evidence.plan.settings.set_word("data", data);
    evidence.plan.settings.set_word("taus", "[1 s, 10, 100]");
    evidence.plan.settings.set_word("deviations", "oadev, mdev, ohdev, totdev");
    evidence.plan.settings.set_word("total_bias", "keep");
    const auto estimate = identify_noise(evidence);
    const std::map<std::string, std::string> measures{{"x oadev", "overlapping_allan"},
                                                      {"x mdev", "modified_allan"},
                                                      {"x ohdev", "overlapping_hadamard"},
                                                      {"x totdev", "total"}};
    for (const auto& [name, measure] : measures) {
      const Curve& curve = curve_named(estimate, name);
      ASSERT_EQ(curve.x.values, (std::vector<double>{1.0, 10.0, 100.0})) << data << " " << name;
      for (std::size_t i = 0; i < 3; ++i)  // 7 digits are printed
        EXPECT_NEAR(curve.y.values[i] / published(measure, curve.x.values[i]), 1.0, 1e-6) << data << " " << name;
    }
  };
  expect(QuantityKind::other, "1", values, "frequency");
  expect(QuantityKind::time, "s", sums, "phase");
  expect(QuantityKind::angular_rate, "rad/s", values, "rate");
  expect(QuantityKind::angle, "rad", sums, "angle");
  expect(QuantityKind::angle, "rad", values, "increment");
}

TEST(NoiseInput, DecadeIsOneTwoFour) {
  Evidence evidence = clock_evidence();
  evidence.plan.settings.set_word("taus", "decade");
  const auto estimate = identify_noise(evidence);
  EXPECT_EQ(curve_named(estimate, "phase allan_deviation").x.values,
            (std::vector<double>{1, 2, 4, 10, 20, 40, 100, 200}));
}

/// The same gyro, 0.1 deg/sqrt(h) at 10 Hz, as its rate and as what follows from it.
TEST(NoiseInput, AngleIncrementsAndCountsGiveTheNoiseOfTheRate) {
  std::vector<double> rate(20000, 1e-3), angle{0.0}, increments, counts;
  add_noise({.angle_random_walk = si(0.1, "deg/sqrt(h)")}, 10.0, RandomStream(1), rate);
  const double pulse = si(0.001, "arcsec");
  for (const double value : rate) {
    increments.push_back(value / 10.0);
    angle.push_back(angle.back() + value / 10.0);
    counts.push_back(std::round(angle.back() / pulse) - std::round((angle.back() - value / 10.0) / pulse));
  }
  const auto walk = [](QuantityKind kind, const char* unit, std::vector<double> values, const char* data) {
    Evidence evidence = noise_evidence({{"gyro", kind, Unit::parse(unit), {0.0, 10.0, nullptr}, std::move(values)}});
    evidence.plan.settings.set_word("data", data);
    if (kind == QuantityKind::count) evidence.plan.settings.set_word("pulse", "0.001 arcsec");
    return find_parameter(identify_noise(evidence), "gyro.angle_random_walk")->value;
  };
  const double truth = walk(QuantityKind::angular_rate, "deg/h", rate, "rate");
  EXPECT_NEAR(walk(QuantityKind::angle, "arcsec", angle, "angle") / truth, 1.0, 1e-6);
  EXPECT_NEAR(walk(QuantityKind::angle, "arcsec", increments, "increment") / truth, 1.0, 1e-9);
  // A sample is 6000 pulses: their rounding is 1e-4 of the noise.
  EXPECT_NEAR(walk(QuantityKind::count, "pulse", counts, "count") / truth, 1.0, 1e-3);
}

TEST(NoiseInput, TheQuantityIsCheckedAndNotGuessed) {
  const auto refused = [](QuantityKind kind, const char* unit, const char* data) {
    Evidence evidence =
        noise_evidence({{"x", kind, Unit::parse(unit), {0.0, 10.0, nullptr}, std::vector<double>(100, 1.0)}});
    evidence.plan.settings.set_word("data", data);
    return refusal_of([&] { identify_noise(evidence); });
  };
  EXPECT_TRUE(
      refuses(Error::Kind::bad_data, Asked{.pattern = "angular rate"}, refused(QuantityKind::angle, "arcsec", "rate")));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "an angle or a velocity"},
                      refused(QuantityKind::angular_rate, "deg/h", "increment")));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "fractional frequency"},
                      refused(QuantityKind::other, "V", "frequency")));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "pulse = 0.5 arcsec"},
                      refused(QuantityKind::count, "pulse", "count")));
  Evidence evidence = clock_evidence();
  evidence.plan.settings.set_word("taus", "1 s, soon");
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input, Asked{.values = {"soon"}, .pattern = "taus"}, [&] { identify_noise(evidence); }));
  evidence.plan.settings.set_word("taus", "1 s, 1 h");
  EXPECT_TRUE(
      refuses(Error::Kind::bad_data, Asked{.values = {"1 h"}, .pattern = "taus"}, [&] { identify_noise(evidence); }));
}

}  // namespace
}  // namespace tumble::allan_noise
