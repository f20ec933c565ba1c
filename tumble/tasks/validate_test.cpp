#include "tumble/tasks/validate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/departures/remedies.hpp"
#include "tumble/language/said.hpp"
#include "tumble/report/in_language.hpp"
#include "tumble/tasks/departed.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/tasks/validation/coverage.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// 24 positions of an accelerometer at one sample a second: a test takes a millisecond or two.
Plan tumble_of_an_accelerometer() {
  return load_plan(std::string(TUMBLE_SOURCE_DIR) + "/plans/accelerometer_tumble.toml", {});
}

Validation validated(const char* departure, std::size_t trials, std::optional<Quantity> size = {}) {
  return validate(tumble_of_an_accelerometer(), {.trials = trials, .departure = departure, .size = size}, {});
}

/// That of a gain, once for all tests.
const Validation& validated_gain() {
  static const Validation validation = validated("output_gain", 40);
  return validation;
}

const ValidatedParameter& parameter_of(const Validation& validation, const std::string& name) {
  return *std::ranges::find(validation.parameters, name, &ValidatedParameter::name);
}

const Table& table_of(const Estimate& estimate, const char* name) {
  const Table* found = find_table(estimate, name);
  if (found == nullptr) throw Error(Error::Kind::internal, say("no table {}", name));
  return *found;
}

TEST(Validate, TestAsPlannedHoldsAndScattersAsPredicted) {
  const Validation& validation = validated_gain();
  ASSERT_FALSE(validation.parameters.empty());
  const ValidatedParameter& bias = parameter_of(validation, "bias");
  EXPECT_EQ(bias.tests, 40u);
  EXPECT_GE(bias.held, 34u);  // 38 - 4, which is 3 sd of the binomial distribution
  EXPECT_LT(bias.coverage_lower, bias.coverage());
  EXPECT_NEAR(std::log(bias.scatter / bias.predicted.value()), 0.0, 0.4);  // 3.5 sd of a deviation of 40
  EXPECT_LT(std::abs(bias.bias), 4.0 * bias.scatter / std::sqrt(40.0));
  EXPECT_EQ(validation.sound.tests, 40u);
  EXPECT_EQ(validation.sound.refused, 0u);
}

/// A gain of the acquisition is a scale factor: it moves the parameter by its sd where it is that sd, and nothing names it.
TEST(Validate, GainOfTheAcquisitionMovesTheScaleFactorAndIsNotNoticed) {
  const Validation& validation = validated_gain();
  ASSERT_EQ(validation.departures.size(), 1u);
  const DepartureStudy& gain = validation.departures.front();
  EXPECT_EQ(gain.exposure, Exposure::unnoticed);
  EXPECT_EQ(gain.parameter, "scale_factor");
  const ValidatedParameter& scale_factor = parameter_of(validation, "scale_factor");
  EXPECT_NEAR(gain.moves, scale_factor.stated / *scale_factor.truth, 0.2 * gain.moves);
  EXPECT_TRUE(std::isnan(gain.named) || gain.named > gain.greatest);
  EXPECT_GT(gain.shift, 1.0);
}

/// A position that lacks is named at once: nothing is left to go wrong.
TEST(Validate, MissingPositionIsNamedInTime) {
  const Validation validation = validated("position_missing", 10);
  ASSERT_EQ(validation.departures.size(), 1u);
  EXPECT_EQ(validation.departures.front().exposure, Exposure::named_in_time);
  EXPECT_FALSE(validation.departures.front().sized);
  EXPECT_FALSE(validation.departures.front().codes.empty());
}

TEST(Validate, OneSizeAloneIsTried) {
  const Validation small = validated("output_gain", 10, Quantity{0.001, Unit::parse("ppm")});
  EXPECT_EQ(small.departures.front().exposure, Exposure::harmless);
  const Validation great = validated("output_gain", 10, Quantity{1.0, Unit::parse("%")});
  EXPECT_NE(great.departures.front().exposure, Exposure::harmless);
}

TEST(Validate, AnswersAreTheSameAgain) {
  const auto of = [] { return validated("output_gain", 10).departures.front(); };
  const DepartureStudy a = of(), b = of();
  EXPECT_EQ(a.moves, b.moves);
  EXPECT_EQ(a.shift, b.shift);
  EXPECT_EQ(a.parameter, b.parameter);
}

TEST(Validate, RefusesWhatCannotBeValidated) {
  Plan plan = tumble_of_an_accelerometer();
  EXPECT_THROW(validate(plan, {.trials = 9}, {}), Error);
  EXPECT_THROW(validate(plan, {.departure = "no_such_departure"}, {}), Error);
  EXPECT_THROW(validate(plan, {.size = Quantity{1.0, {}}}, {}), Error);
  EXPECT_THROW(validate(plan, {.target = "head"}, {}), Error);
  EXPECT_THROW(validate(plan, {.departure = "cross_motion"}, {}), Error) << "a dividing head has no shaker";
  EXPECT_THROW(validated("output_gain", 10, Quantity{1.0, Unit::parse("deg")}), Error);
  EXPECT_THROW(validated("labels_exchanged", 10, Quantity{1.0, {}}), Error);
  plan.method.clear();
  EXPECT_THROW(validate(plan, {}, {}), Error);
}

TEST(Validate, ReportHasWhatCouldGoWrongAndWhatWouldShowIt) {
  const Estimate report = report_of(validated_gain());
  EXPECT_EQ(table_of(report, "unnoticed").rows.size(), 1u);
  EXPECT_EQ(std::get<std::string>(table_of(report, "what_would_show_it").rows.at(0).at(1)), remedy_of("output_gain"));
  EXPECT_FALSE(table_of(report, "coverage").rows.empty());
  EXPECT_TRUE(std::ranges::any_of(report.findings, [](const Finding& f) { return f.code == "departures_unnoticed"; }));
  EXPECT_TRUE(report.provenance.seed) << "a simulated result";
}

TEST(Validate, ReportIsChineseExceptForNames) {
  const Estimate report = report_of(validated_gain());
  const Estimate chinese = in_language(Language::chinese, report);
  for (std::size_t t = 0; t < report.tables.size(); ++t) {
    EXPECT_NE(chinese.tables[t].caption, report.tables[t].caption);
    EXPECT_TRUE(result_words_in(Language::chinese, report.tables[t].name)) << report.tables[t].name;
    for (std::size_t c = 0; c < report.tables[t].columns.size(); ++c)
      EXPECT_NE(chinese.tables[t].columns[c].name, report.tables[t].columns[c].name);
  }
  EXPECT_EQ(table_of(chinese, "unnoticed").rows[0][0], table_of(report, "unnoticed").rows[0][0]) << "a name stays";
}

TEST(Validate, ShareOfTestsHasTheIntervalOfWilson) {
  const auto [lower, upper] = validation::share_interval(95, 100, 1.959964);
  EXPECT_NEAR(lower, 0.88825, 1e-5);  // published: Wilson's interval of 95 of 100
  EXPECT_NEAR(upper, 0.97846, 1e-5);
  EXPECT_NEAR(validation::share_interval(10, 10, 1.959964).lower, 0.72246, 1e-5);
  EXPECT_EQ(validation::share_interval(0, 0, 1.96).upper, 1.0);
}

TEST(Remedies, EveryDepartureHasOneInBothLanguages) {
  for (const Departure& departure : departure_catalogue()) {
    EXPECT_FALSE(remedy_of(departure.name).empty()) << departure.name;
    EXPECT_TRUE(result_words_in(Language::chinese, remedy_of(departure.name))) << departure.name;
  }
}

TEST(DepartedTest, IsReadAsPeopleWriteIt) {
  const WantedDeparture wanted = wanted_departure("positions_offset:head=20 arcsec");
  EXPECT_STREQ(wanted.departure->name, "positions_offset");
  EXPECT_EQ(wanted.target, "head");
  EXPECT_EQ(wanted.size->value, 20.0);
  EXPECT_FALSE(wanted_departure("order_changed").size);
  EXPECT_THROW(wanted_departure("order_changed=1"), Error);
  EXPECT_THROW(wanted_departure("clock_fast"), Error);
  EXPECT_THROW(wanted_departure("clock_fast=fast"), Error);
  EXPECT_THROW(wanted_departures({"clock_fast=1 ppm", "clock"}), Error);
  EXPECT_THROW(size_in(Quantity{1.0, {}, true}, Unit::parse("ppm")), Error) << "a number alone is ambiguous";
}

TEST(DepartedTest, IsSimulatedOnTheCommandLineAsInValidations) {
  const Plan plan = tumble_of_an_accelerometer();
  const SimulatedTest sound = simulated_test(plan, 3);
  const Departure& departure = find_departure("clock_fast");
  const SimulatedTest one = with_departure(sound, departure, "", si(300.0, "ppm"), 3);
  const Recordings other = simulate_departed(plan, wanted_departures({"clock_fast=300 ppm"}), 3);
  ASSERT_EQ(other.size(), 1u);
  EXPECT_EQ(other.front().meta.at("departures"), "clock_fast=300 ppm");
  EXPECT_EQ(other.front().channels.front().timeline.rate,
            one.evidence.recordings.front().channels.front().timeline.rate);
  EXPECT_NE(other.front().channels.front().timeline.rate,
            sound.evidence.recordings.front().channels.front().timeline.rate);
  EXPECT_EQ(other.front().channels.front().values, one.evidence.recordings.front().channels.front().values);
}

}  // namespace
}  // namespace tumble
