#include "tumble/archive/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/archive/history.hpp"
#include "tumble/archive/notes.hpp"
#include "tumble/archive/testing/samples.hpp"
#include "tumble/core/instant.hpp"
#include "tumble/core/testing/asserts.hpp"
#include "tumble/exchange/comparison.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/math/population/capability.hpp"
#include "tumble/math/random.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

const Unit shown_unit = Unit::parse("deg/h");

/// Noon of a day after 2026-01-01.
std::string noon(int day, int hour = 12) {
  constexpr std::int64_t second = 1'000'000'000;
  const auto begin = parse_iso_time("2026-01-01T00:00:00Z").value_or(0);
  return iso_time(begin + (std::int64_t{day} * 24 + hour) * 3600 * second).substr(0, 19) + "Z";
}

class ArchiveStatistics : public ::testing::Test {
 protected:
  void SetUp() override {
    make_archive(folder_.file("lab.db"), "", testing::sample_act());
    archive_.emplace(folder_.file("lab.db"));
  }
  void add(const testing::SampleResult& sample) { deposit_.results.push_back(testing::sample_deposit(sample)); }
  void put() {
    put_in(*archive_, deposit_, testing::sample_act());
    deposit_ = {};
  }
  static const Table& table(const Estimate& estimate, const std::string& name) {
    const auto* found = find_table(estimate, name);
    if (!found) throw std::runtime_error("no table " + name);
    return *found;
  }

  ScratchFolder folder_;
  std::optional<Archive> archive_;
  Deposit deposit_;
  const RandomStream random_{11};
};

TEST_F(ArchiveStatistics, AChartHasTheNumbersOfTheMathematics) {
  std::vector<ChartPoint> points;
  for (int i = 0; i < 50; ++i) {
    const double value = 1.0 + 0.2 * random_.normal(static_cast<std::uint64_t>(i));
    add({.bias = value, .ended = noon(i)});
    points.push_back({shown_unit.to_si(value), shown_unit.to_si(0.1)});
  }
  put();
  const auto estimate = chart_of_archive(*archive_, {.what = {"bias", {}, {"gyro", "0173"}}});
  const ChartSettings settings{.baseline = 25};
  const auto chart = control_chart(points, settings, chart_limits(settings));
  EXPECT_NEAR(estimate.parameters[0].value, chart.baseline.mean, 1e-12 * std::abs(chart.baseline.mean));
  const auto& rows = table(estimate, "chart").rows;
  ASSERT_EQ(rows.size(), 50u);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(std::get<double>(rows[i][6]), chart.points[i].limit, 1e-9 * chart.points[i].limit) << i;
    EXPECT_NEAR(std::get<double>(rows[i][7]), chart.points[i].ewma, 1e-9 * chart.points[i].limit) << i;
    EXPECT_NEAR(std::get<double>(rows[i][9]), chart.points[i].up, 1e-9) << i;
  }
  EXPECT_FALSE(to_text(estimate).empty());
  EXPECT_EQ(estimate_from_json(to_json(estimate), "x").tables.size(), estimate.tables.size());
}

TEST_F(ArchiveStatistics, EachPointOfAChartLeadsToItsResult) {
  for (int i = 0; i < 6; ++i) add({.bias = 1.0 + 0.1 * i, .ended = noon(i)});
  put();
  const auto record = unit_record(*archive_, {"gyro", "0173"});
  for (const bool chart : {true, false}) {
    const auto estimate = chart ? chart_of_archive(*archive_, {.what = {"bias", {}, {"gyro", "0173"}}})
                                : drift_of_unit(*archive_, {.what = {"bias", {}, {"gyro", "0173"}}});
    const auto& links = table(estimate, "links").rows;
    ASSERT_EQ(links.size(), 6u);
    for (std::size_t i = 0; i < links.size(); ++i) {
      const auto number = std::stoll(std::get<std::string>(links[i][4]));
      EXPECT_EQ(sha256_by_number(*archive_, {number}).at(number), record.results[i].sha256);
      EXPECT_EQ(std::get<double>(links[i][2]), estimate.curves[0].y.values[i]);
      EXPECT_EQ(std::get<double>(links[i][1]), estimate.curves[0].x.values[i]);
    }
  }
  EXPECT_TRUE(sha256_by_number(*archive_, {12345}).empty());
}

TEST_F(ArchiveStatistics, AStepIsAnAlarmAndARecalibratedRigIsNone) {
  for (int i = 0; i < 60; ++i) {
    const double noise = 0.1 * random_.normal(static_cast<std::uint64_t>(i));
    const double step = i >= 40 ? 0.8 : 0.0;  // 8 sd of a result, 1.1 sd of the difference of two rigs
    const std::string later = i >= 40 ? "rig, certificate 2" : "rig, certificate 1";
    add({.serial = "same rig", .bias = step + noise, .ended = noon(i), .rig = "rig, certificate 1"});
    add({.serial = "rig again", .bias = step + noise, .ended = noon(i), .rig = later});
  }
  put();
  const auto same = chart_of_archive(*archive_, {.what = {"bias", {}, {"gyro", "same rig"}}});
  EXPECT_TRUE(has_finding(same.findings, "chart_points_beyond"));
  EXPECT_TRUE(has_finding(same.findings, "chart_drifts"));
  EXPECT_GE(table(same, "alarms").rows.size(), 20u);
  const auto again = chart_of_archive(*archive_, {.what = {"bias", {}, {"gyro", "rig again"}}});
  EXPECT_FALSE(has_finding(again.findings, "chart_points_beyond"));
  EXPECT_FALSE(has_finding(again.findings, "chart_drifts"));
  EXPECT_FALSE(has_finding(again.findings, "chart_shifted"));
  EXPECT_TRUE(has_finding(again.findings, "chart_sources_changed"));
  const auto& rows = table(again, "chart").rows;
  EXPECT_EQ(std::get<double>(rows[30][4]), 0.0) << "nothing has changed yet";
  // Of both certificates one error of 0.5 deg/h each: the root of the sum of their squares.
  EXPECT_NEAR(shown_unit.from_si(std::get<double>(rows[50][4])), std::sqrt(0.5), 1e-9);
}

TEST_F(ArchiveStatistics, ResultsOfOneDayAreOnePoint) {
  for (int day = 0; day < 8; ++day)
    for (int repeat = 0; repeat < 4; ++repeat) add({.bias = 1.0 * day + 0.01 * repeat, .ended = noon(day, 8 + repeat)});
  put();
  const auto estimate = chart_of_archive(*archive_, {.what = {"bias", {}, {"gyro", "0173"}}});
  const auto& rows = table(estimate, "chart").rows;
  ASSERT_EQ(rows.size(), 8u);
  EXPECT_NEAR(shown_unit.from_si(std::get<double>(rows[3][2])), 3.015, 1e-9);
  EXPECT_NEAR(shown_unit.from_si(std::get<double>(rows[3][3])), 0.05, 1e-9);  // 0.1 of four results
}

TEST_F(ArchiveStatistics, TwoRigsOfOneDayAreTwoPointsInAnyOrder) {
  for (int day = 0; day < 4; ++day)
    for (int repeat = 0; repeat < 4; ++repeat)
      add({.bias = 1.0 + 0.01 * repeat, .ended = noon(day, 8 + repeat), .rig = repeat % 2 == 0 ? "rig A" : "rig B"});
  put();
  EXPECT_EQ(table(chart_of_archive(*archive_, {.what = {"bias", {}, {"gyro", "0173"}}}), "chart").rows.size(), 8u);
}

TEST_F(ArchiveStatistics, ResultsOfTheSameRecordingsAreSaid) {
  for (int day = 0; day < 4; ++day)
    add({.bias = 1.0 + day, .ended = noon(day), .recording_sha256 = std::string(64, static_cast<char>('a' + day))});
  put();
  const ChartRequest request{.what = {"bias", {}, {"gyro", "0173"}}};
  EXPECT_FALSE(has_finding(chart_of_archive(*archive_, request).findings, "archived_twice"));
  add({.bias = 1.001, .ended = noon(0), .recording_sha256 = std::string(64, 'a')});
  put();
  EXPECT_TRUE(has_finding(chart_of_archive(*archive_, request).findings, "archived_twice"));
}

TEST_F(ArchiveStatistics, QuantitiesOfOneNameAreNotMixed) {
  for (int unit = 0; unit < 6; ++unit) {
    add({.serial = std::to_string(unit), .ended = noon(unit)});
    add({.serial = "a" + std::to_string(unit), .ended = noon(unit)});
    auto& json = deposit_.results.back().json;
    for (auto at = json.find("deg/h"); at != std::string::npos; at = json.find("deg/h")) json.replace(at, 5, "ug");
    deposit_.results.back().unit.model = "accelerometer";
  }
  put();
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"bias"}, .pattern = "not the same quantity"}, [&] {
    chart_of_archive(*archive_, {.what = {"bias", {}, {}}});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"bias"}, .pattern = "not the same quantity"}, [&] {
    summary_of_model(*archive_, {.what = {"bias", {}, {}}});
  }));
  const auto estimate = chart_of_archive(*archive_, {.what = {"bias", "accelerometer", {}}});
  EXPECT_EQ(estimate.parameters[0].unit.text(), "ug");
  EXPECT_EQ(table(estimate, "chart").rows.size(), 6u);
}

TEST_F(ArchiveStatistics, AChartOverUnitsTakesEachOnceOrEachDay) {
  for (int unit = 0; unit < 12; ++unit)
    for (int day = 0; day < 3; ++day)
      add({.serial = std::to_string(unit), .bias = 0.1 * (unit % 5), .ended = noon(3 * unit + day)});
  put();
  EXPECT_EQ(table(chart_of_archive(*archive_, {.what = {"bias", "gyro", {}}}), "chart").rows.size(), 12u);
  EXPECT_EQ(table(chart_of_archive(*archive_, {.what = {"bias", "gyro", {}}, .every_day = true}), "chart").rows.size(),
            36u);
}

TEST_F(ArchiveStatistics, PointsThatAreTooFewOrAbsentAreRefused) {
  for (int i = 0; i < 3; ++i) add({.bias = 1.0 * i, .ended = noon(i)});
  put();
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"bias", "3"}}, [&] {
    chart_of_archive(*archive_, {.what = {"bias", {}, {"gyro", "0173"}}});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"bais", "bias"}}, [&] {
    chart_of_archive(*archive_, {.what = {"bais", {}, {}}});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"other", "bias"}}, [&] {
    chart_of_archive(*archive_, {.what = {"bias", "other", {}}});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"bias", "1"}}, [&] {
    summary_of_model(*archive_, {.what = {"bias", "gyro", {}}});
  }));
}

TEST_F(ArchiveStatistics, DriftComparesWithSharedErrorsSubtracted) {
  const std::vector<double> values{1.0, 1.1, 1.6};
  for (std::size_t i = 0; i < values.size(); ++i)
    add({.bias = values[i], .ended = noon(static_cast<int>(300 * i)), .rig = "rig, certificate 1"});
  put();
  const auto estimate = drift_of_unit(*archive_, {.what = {"bias", {}, {"gyro", "0173"}}});
  const auto& rows = table(estimate, "history").rows;
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_TRUE(std::isnan(std::get<double>(rows[0][3])));
  // The rig's 0.5 is shared: only 0.1 of each result remains.
  EXPECT_NEAR(std::get<double>(rows[2][3]), 0.5 / (1.959964 * 0.1 * std::sqrt(2.0)), 1e-6);
  EXPECT_NEAR(std::get<double>(rows[2][4]), 0.6 / (1.959964 * 0.1 * std::sqrt(2.0)), 1e-6);
  EXPECT_TRUE(has_finding(estimate.findings, "drift_of_few_units"));
  EXPECT_EQ(find_table(estimate, "recalibration"), nullptr) << "there are no limits";
}

TEST_F(ArchiveStatistics, AnAdjustmentBeginsTheHistoryAnew) {
  for (int i = 0; i < 4; ++i) add({.bias = i < 2 ? 5.0 : 1.0, .ended = noon(100 * i)});
  put();
  put_note(*archive_, {"0173", "adjusted", "trimmed", noon(150)}, testing::sample_act());
  const auto estimate = drift_of_unit(*archive_, {.what = {"bias", {}, {"gyro", "0173"}}});
  EXPECT_EQ(table(estimate, "history").rows.size(), 2u);
  EXPECT_TRUE(has_finding(estimate.findings, "history_since_adjustment"));
}

TEST_F(ArchiveStatistics, AdjustmentsAreNoRandomWalkAndNoAlarm) {
  // 10 units that do not drift; between the visits 3 and 4 each is trimmed by up to 9 deg/h.
  for (std::uint64_t unit = 0; unit < 10; ++unit)
    for (int visit = 0; visit < 12; ++visit)
      add({.serial = std::to_string(unit),
           .bias = 0.1 * random_.split(unit).normal(static_cast<std::uint64_t>(visit)) +
                   (visit > 3 ? static_cast<double>(unit) : 0.0),
           .ended = noon(100 * visit)});
  put();
  for (int unit = 0; unit < 10; ++unit)
    put_note(*archive_, {std::to_string(unit), "adjusted", "trimmed", noon(350)}, testing::sample_act());
  const ArchivedSelection last{"bias", {}, {"gyro", "9"}};
  const auto drift = drift_of_unit(*archive_, {.what = last});
  // The sd of a result over the root of 100 days is 0.01; of the trims it would be 0.1 and more.
  EXPECT_LT(find_parameter(drift, "bias_random_walk")->upper, Unit::parse("deg/h/sqrt(day)").to_si(0.02));
  const auto chart = chart_of_archive(*archive_, {.what = last});
  EXPECT_EQ(table(chart, "chart").rows.size(), 8u);
  EXPECT_TRUE(has_finding(chart.findings, "history_since_adjustment"));
  for (const auto& point : table(chart, "chart").rows) EXPECT_EQ(std::get<std::string>(point[12]), "");
}

TEST_F(ArchiveStatistics, TheIntervalComesFromTheRandomWalkOfTheModel) {
  // 20 units with yearly results and a random walk of 0.3 deg/h a root year.
  for (std::uint64_t unit = 0; unit < 20; ++unit) {
    double walk = 0.0;
    for (std::uint64_t year = 0; year < 5; ++year) {
      if (year > 0) walk += 0.3 * random_.split(unit).normal(2 * year);
      add({.serial = std::to_string(unit),
           .bias = walk + 0.1 * random_.split(unit).normal(2 * year + 1),
           .ended = noon(static_cast<int>(365 * year))});
    }
  }
  put();
  DriftRequest request{.what = {"bias", {}, {"gyro", "3"}}};
  request.limits = {shown_unit.to_si(-3.0), shown_unit.to_si(3.0)};
  const auto estimate = drift_of_unit(*archive_, request);
  const auto* walk = find_parameter(estimate, "bias_random_walk");
  ASSERT_NE(walk, nullptr);
  const double year = std::sqrt(365.0);
  EXPECT_LT(walk->unit.from_si(walk->lower) * year, 0.3);
  EXPECT_GT(walk->unit.from_si(walk->upper) * year, 0.3);
  const auto& row = table(estimate, "recalibration").rows.at(0);
  const double interval = std::get<double>(row[0]), offered = std::get<double>(row[3]);
  EXPECT_GT(interval, 365.0 * 86400.0);
  EXPECT_LE(offered, interval);
  EXPECT_LE(offered, 2.0 * 365.0 * 86400.0) << "twice the longest interval that was seen";
}

TEST_F(ArchiveStatistics, ASummarySeparatesUnitsDaysAndTheMeasurement) {
  std::vector<UnitValue> means;
  for (std::uint64_t unit = 0; unit < 30; ++unit) {
    const double truth = 1.0 + random_.split(unit).normal(0) + (unit == 7 ? 12.0 : 0.0);
    for (std::uint64_t day = 0; day < 4; ++day) {
      const double of_day = truth + 0.3 * random_.split(unit).normal(1 + day);
      for (std::uint64_t repeat = 0; repeat < 2; ++repeat)
        add({.serial = std::to_string(unit),
             .bias = of_day + 0.1 * random_.split(unit).normal(100 + 10 * day + repeat),
             .ended = noon(static_cast<int>(4 * unit + day), static_cast<int>(8 + repeat))});
    }
  }
  put();
  SummaryRequest request{.what = {"bias", "gyro", {}}};
  request.limits.upper = shown_unit.to_si(5.0);
  const auto estimate = summary_of_model(*archive_, request);
  const auto holds = [&](const std::string& name, double truth) {
    const auto* found = find_parameter(estimate, name);
    ASSERT_NE(found, nullptr) << name;
    EXPECT_LT(found->unit.from_si(found->lower), truth) << name;
    EXPECT_GT(found->unit.from_si(found->upper), truth) << name;
  };
  holds("bias_day_sd", 0.3);
  const auto& outliers = table(estimate, "outliers").rows;
  ASSERT_EQ(outliers.size(), 1u);
  EXPECT_EQ(std::get<std::string>(outliers[0][0]), "gyro/7");
  ASSERT_EQ(estimate.curves.size(), 2u);
  EXPECT_EQ(estimate.curves[1].name, "outlier");
  EXPECT_EQ(estimate.curves[1].figure, estimate.curves[0].figure);
  ASSERT_EQ(estimate.curves[1].y.values.size(), 1u);
  EXPECT_EQ(estimate.curves[1].y.values[0], std::get<double>(outliers[0][1]));
  holds("bias_capability", 4.0 / 3.0);
  EXPECT_LT(find_parameter(estimate, "bias_capability_measured")->value, 1.8);
  EXPECT_FALSE(to_json(estimate).empty());
}

TEST_F(ArchiveStatistics, AnotherRigIsNoOtherBatch) {
  for (int unit = 0; unit < 30; ++unit)
    for (const char* const model : {"same rig", "two rigs"}) {
      const bool later = unit >= 15;
      const bool other = later && std::string(model) == "two rigs";
      add({.serial = std::to_string(unit),
           .bias = 5.0 + 0.1 * random_.normal(static_cast<std::uint64_t>(unit)) + (later ? 0.8 : 0.0),
           .ended = noon(unit),
           .rig = other ? "rig, certificate 2" : "rig, certificate 1"});
      deposit_.results.back().unit.model = model;
    }
  put();
  EXPECT_TRUE(has_finding(summary_of_model(*archive_, {.what = {"bias", "same rig", {}}}).findings, "batch_changed"));
  const auto two = summary_of_model(*archive_, {.what = {"bias", "two rigs", {}}});
  EXPECT_FALSE(has_finding(two.findings, "batch_changed"));
  const auto able = summary_of_model(
      *archive_, {.what = {"bias", "two rigs", {}}, .limits = {shown_unit.to_si(4.0), shown_unit.to_si(7.0)}});
  EXPECT_GT(find_parameter(able, "bias_capability")->value, 2.0) << "as for 0.1 and less, not for 0.8 between the rigs";
  // Noise of 0.1 is that of the results: what the rigs differ by is no spread of the units.
  EXPECT_LT(find_parameter(two, "bias_unit_sd")->value, shown_unit.to_si(0.1));
}

TEST_F(ArchiveStatistics, TheMeanOfAModelHoldsWhatAllUnitsShare) {
  for (std::uint64_t unit = 0; unit < 12; ++unit)
    for (std::uint64_t day = 0; day < 2; ++day)
      add({.serial = std::to_string(unit),
           .bias = 1.0 + 0.2 * random_.split(unit).normal(day),
           .ended = noon(static_cast<int>(2 * unit + day)),
           .rig = "rig, certificate 1"});
  put();
  const auto estimate = summary_of_model(*archive_, {.what = {"bias", "gyro", {}}});
  const auto* mean = find_parameter(estimate, "bias_mean");
  ASSERT_NE(mean, nullptr);
  EXPECT_GT(shown_unit.from_si(mean->upper - mean->lower), 2.0 * 1.95 * 0.5) << "the rig is known to 0.5 deg/h";
}

}  // namespace
}  // namespace tumble
