#include "tumble/tasks/optimise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/reduce/terms.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/tasks/optimisation/points.hpp"
#include "tumble/tasks/plan_file/write_schedule.hpp"
#include "tumble/tasks/prediction/problem.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {
namespace {

/// Plans in files of their own.
class Predict : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() / (std::string("predict_") + test->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Plan load(const std::string& text, const std::string& name = "plan.toml") const {
    std::ofstream(folder_ / name) << text;
    return load_plan((folder_ / name).string(), {});
  }

  std::filesystem::path folder_;
};

std::string head(const std::string& model, const std::string& rig, const std::string& options = "") {
  return "[instrument]\nmodel = \"" + model +
         "\"\nrate = \"1 Hz\"\n[site]\nlatitude = \"34.25 deg\"\n[rig]\nkind = \"" + rig + "\"\n" + options;
}

std::string position(int outer, int inner, const std::string& duration) {
  return "[[schedule]]\nlabel = \"" + std::to_string(outer) + " " + std::to_string(inner) + "\"\nduration = \"" +
         duration + "\"\nouter = {hold = \"" + std::to_string(outer) + " deg\"}\ninner = {hold = \"" +
         std::to_string(inner) + " deg\"}\n";
}

/// z up and down, y up and down, x up and down on the two-axis table.
std::string six_faces(const std::string& duration) {
  std::string text;
  for (const auto& [outer, inner] : {std::pair{0, 0}, {90, 0}, {180, 0}, {-90, 0}, {90, 90}, {90, -90}})
    text += position(outer, inner, duration);
  return text;
}

const std::string truth =
    "[truth]\nangle_random_walk = \"0.005 deg/sqrt(h)\"\nD_F = \"3 deg/h\"\nD_I = \"2 deg/h/g\"\n";
const std::vector<std::string> ten_terms{"D_F", "D_I", "D_O", "D_S", "D_IO", "D_OS", "D_IS", "D_II", "D_OO", "D_SS"};

bool finding(const Estimate& estimate, const std::string& part) {
  return std::ranges::any_of(estimate.findings,
                             [&](const Finding& one) { return one.message.find(part) != std::string::npos; });
}

const Table::Cell& cell(const Estimate& estimate, const std::string& table, const std::string& row,
                        const std::string& column) {
  const auto* found = find_table(estimate, table);
  const auto at = std::ranges::find(found->columns, column, &Table::Column::name) - found->columns.begin();
  for (const auto& one : found->rows)
    if (std::get<std::string>(one.front()) == row) return one[static_cast<std::size_t>(at)];
  throw Error(Error::Kind::internal, say("no row {}", Name{row}));
}

double number(const Estimate& estimate, const std::string& row, const std::string& column) {
  return std::get<double>(cell(estimate, "schedules", row, column));
}

std::string told(const Estimate& estimate, const std::string& row) {
  return std::get<std::string>(cell(estimate, "schedules", row, "determined"));
}

TEST_F(Predict, SaysEverythingThatAPlanLacks) {
  const auto plan = load("title = \"empty\"\n");
  try {
    predict(plan);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_input);
    EXPECT_EQ(error.problems.size(), 5u) << "model, rig, rate, schedule, truth";
  }
}

TEST_F(Predict, RefusesToPredictWithoutNoise) {
  const auto plan = load(head("sdof_gyro", "two_axis_table") + six_faces("1 min") + "[truth]\nD_F = \"3 deg/h\"\n");
  try {
    predict(plan);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(error.problems.front().text().find("angle_random_walk"), std::string::npos);
  }
}

TEST_F(Predict, RefusesToPredictAMethodsPlanWithoutNoise) {
  const auto plan = load("method = \"sdof_gyro_static\"\n" + head("sdof_gyro", "two_axis_table") + six_faces("1 min") +
                         "[truth]\nD_F = \"3 deg/h\"\n");
  try {
    predict(plan);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_input);
    EXPECT_NE(error.problems.front().text().find("angle_random_walk"), std::string::npos);
  }
}

// Six faces: 6 of the 10 terms; D_IO, D_OS, D_IS are zero there, D_OO adds up with D_II and D_SS to 1 g^2.
TEST_F(Predict, NamesWhatSixFacesDoNotShowAndWhatWould) {
  const auto plan = load(head("sdof_gyro", "two_axis_table") + six_faces("10 min") + truth);
  const auto estimate = predict_model(plan, ten_terms);
  ASSERT_EQ(estimate.parameters.size(), 6u);
  EXPECT_EQ(estimate.parameters[0].name, "D_F");
  EXPECT_DOUBLE_EQ(estimate.parameters[0].value, si(3.0, "deg/h")) << "the truth";
  const auto said = [&](const char* code, const char* name) { return text_of(estimate.findings, code, name); };
  EXPECT_EQ(said("not_excited", "terms"), "D_IO, D_OS, D_IS");
  EXPECT_TRUE(said("add_to_schedule", "additions").starts_with("outer 45 deg, inner 45 deg"));
  EXPECT_TRUE(said("out_of_reach_of_rig", "terms").starts_with("D_F, D_II, D_OO, D_SS"));
}

// The additions that it advises do show what it says.
TEST_F(Predict, AdviceMendsTheSchedule) {
  const auto plan = load(head("sdof_gyro", "two_axis_table") + six_faces("10 min") + position(45, 45, "10 min") +
                         position(45, -45, "10 min") + position(45, 135, "10 min") + truth);
  EXPECT_EQ(predict_model(plan, ten_terms).parameters.size(), 9u);
}

TEST_F(Predict, TermsThatOnlyProductsOfTheEarthsRateExciteAreNotExcited) {
  const auto plan = load(head("sdof_gyro", "two_axis_table") + six_faces("10 min") + truth);
  EXPECT_TRUE(finding(predict(plan), "K_III"));
}

TEST_F(Predict, BudgetAddsUpAndSeveralOutputsStandInOneEstimate) {
  std::string schedule;
  int n = 0;
  for (const char* pose :
       {"mount_roll = {hold = \"0 deg\"}", "mount_roll = {hold = \"90 deg\"}", "mount_roll = {hold = \"180 deg\"}",
        "mount_roll = {hold = \"-90 deg\"}", "mount_roll = {hold = \"0 deg\"}\nmount_pitch = {hold = \"90 deg\"}",
        "mount_pitch = {hold = \"-90 deg\"}"})
    schedule += "[[schedule]]\nlabel = \"" + std::to_string(++n) + "\"\nduration = \"2 min\"\n" + pose + "\n";
  const auto estimate = predict(load(head("triad", "by_hand") + schedule +
                                     "[truth]\naccelerometer_angle_random_walk = \"0.01 (m/s)/sqrt(h)\"\n"));
  EXPECT_TRUE(find_parameter(estimate, "accelerometer_x_bias") && find_parameter(estimate, "accelerometer_z_bias"));
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    double sum = 0.0;
    for (const auto& line : estimate.budget) sum += line.variance(i);
    EXPECT_NEAR(sum, estimate.covariance(i, i), 1e-9 * estimate.covariance(i, i)) << estimate.parameters[i].name;
  }
}

// The scatter of identified values over simulated tests, rig errors and drift drawn anew in each: 120 seeds give a
// standard deviation to 1/sqrt(2 119) = 6.5 %, four times that is 26 %.
TEST_F(Predict, AgreesWithTheScatterOfSimulatedTests) {
  std::string schedule = six_faces("3 min");
  for (const auto& [outer, inner] : {std::pair{45, 0}, {135, 0}, {90, 45}, {90, -45}, {45, 90}, {-45, 90}})
    schedule += position(outer, inner, "3 min");
  const auto plan = load(head("sdof_gyro", "two_axis_table", "mount_sd = \"60 arcsec\"\n") + schedule + truth +
                         "bias_instability = \"0.01 deg/h\"\n");
  const auto predicted = predict_model(plan, ten_terms);
  const auto outputs = prediction::output_problems(plan, prediction::felt_over(plan), ten_terms);
  const int seeds = 120;
  std::vector<double> sum(predicted.parameters.size()), squares(sum.size());
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto estimate =
        identify_terms({plan, {simulate(plan, static_cast<std::uint64_t>(seed), {})}}, outputs.front().problem);
    ASSERT_EQ(estimate.parameters.size(), sum.size());
    for (std::size_t k = 0; k < sum.size(); ++k) {
      const double error = estimate.parameters[k].value - predicted.parameters[k].value;
      sum[k] += error / seeds;
      squares[k] += error * error / seeds;
    }
  }
  for (std::size_t k = 0; k < sum.size(); ++k) {
    const double sd = standard_uncertainty(predicted, k);
    EXPECT_NEAR(std::sqrt(squares[k]) / sd, 1.0, 0.26) << predicted.parameters[k].name;
    EXPECT_LT(std::abs(sum[k]), 4.0 * sd / std::sqrt(seeds)) << predicted.parameters[k].name;
  }
}

/// I(d) = X'(1/d + N N')^-1 X for two durations gives X'X and I at any third duration.
TEST(DesignSpace, TwoDurationsGiveTheThird) {
  DesignPoint point{Matrix(3, 4), Matrix(3, 2), 0.0, 0.0};
  RandomStream(3).normal(0, point.rows.values);
  RandomStream(4).normal(0, point.disturbance.values);
  const auto found = optimisation::point_of(information(point, 10.0), information(point, 20.0), 10.0);
  const auto expected = information(point, 57.0), got = information(found, 57.0);
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(got.values[i], expected.values[i], 1e-7 * expected(0, 0));
}

/// Sets on an ideal rig: ranks and, to the digit quoted, the conditions of unit columns 4.3, 6.0 and 5.1; the time is
/// shared out evenly but for the moves (some 1 %).
TEST_F(Predict, StandardSchedulesHaveTheKnownRanksAndConditions) {
  const auto plan = load(head("sdof_gyro", "two_axis_table", "ideal = true\n") + six_faces("20 min") + truth);
  OptimiseOptions options;
  options.terms = ten_terms;
  options.step = si(45.0, "deg");
  const auto found = optimise(plan, options, {}).estimate;
  EXPECT_EQ(told(found, "plan as it is"), "6 of 9");
  EXPECT_EQ(told(found, "6 faces"), "6 of 9");
  EXPECT_EQ(told(found, "12 edges"), "9 of 9");
  EXPECT_NEAR(number(found, "6 faces + 12 edges", "condition"), 4.3, 0.05);
  EXPECT_NEAR(number(found, "12 edges", "condition"), 6.0, 0.05);
  EXPECT_NEAR(number(found, "6 faces + 12 edges + 8 corners", "condition"), 5.1, 0.05);
  for (const char* other : {"12 edges", "6 faces + 12 edges", "6 faces + 12 edges + 8 corners"}) {
    EXPECT_LT(number(found, "A-optimal", "trace"), number(found, other, "trace")) << other;
    EXPECT_LT(number(found, "D-optimal", "det"), number(found, other, "det")) << other;
    EXPECT_NEAR(number(found, other, "time"), 7200.0, 1.0);
  }
  EXPECT_NEAR(number(found, "A-optimal", "time"), 7200.0, 1e-6);
}

// 24 orientations of the dynamically tuned gyro: f_X f_Z and f_Y f_Z vanish, 4 of 6; with the 12 edges all, orthogonal.
TEST_F(Predict, TunedGyroInTwentyFourOrientations) {
  const auto plan =
      load(head("dynamically_tuned_gyro", "three_axis_table", "ideal = true\n") +
           "[[schedule]]\nlabel = \"1\"\nduration = \"4 h\"\nouter = {hold = \"0 deg\"}\nmiddle = {hold = "
           "\"0 deg\"}\ninner = {hold = \"0 deg\"}\n[truth]\nangle_random_walk = \"0.005 deg/sqrt(h)\"\n");
  OptimiseOptions options;
  options.terms = {"D_F", "D_x", "D_y", "D_z", "D_xz", "D_yz"};
  options.step = si(45.0, "deg");
  const auto found = optimise(plan, options, {}).estimate;
  EXPECT_EQ(told(found, "24 cube orientations"), "4 of 6");
  EXPECT_EQ(told(found, "24 cube orientations + 12 edges"), "6 of 6");
  EXPECT_NEAR(number(found, "24 cube orientations + 12 edges", "condition"), 1.0, 0.05);
}

TEST_F(Predict, OptimisedScheduleStaysWithinTheRigAndTheTime) {
  const auto plan =
      load(head("sdof_gyro", "two_axis_table", "outer_lowest = \"-100 deg\"\nouter_highest = \"100 deg\"\n") +
           position(0, 0, "10 min") + position(90, 45, "20 min") + position(0, 0, "10 min") + truth +
           "bias_instability = \"0.002 deg/h\"\n");
  OptimiseOptions options;
  options.terms = ten_terms;
  options.step = si(45.0, "deg");
  options.criterion = DesignCriterion::D;
  options.total_time = 3600.0;
  options.steps = 60;
  const auto found = optimise(plan, options, {});
  EXPECT_TRUE(find_rig("two_axis_table").refusals(found.schedule, plan.rig).empty());
  double total = 0.0;
  for (const auto& segment : found.schedule) total += segment.duration;
  EXPECT_NEAR(total, 3600.0, 1e-6);
  EXPECT_EQ(found.schedule.front().axes.at("outer").value, found.schedule.back().axes.at("outer").value);
  EXPECT_EQ(found.schedule.front().axes.at("inner").value, found.schedule.back().axes.at("inner").value)
      << "the plan closes with a repeat of its first position";
}

TEST_F(Predict, WrittenPlanIsTheScheduleFoundAndKeepsEverythingElse) {
  const auto plan = load("# a comment\n" + head("sdof_gyro", "two_axis_table") + "\n# faces\n" + six_faces("5 min") +
                         "\n# what it is\n" + truth);
  OptimiseOptions options;
  options.terms = ten_terms;
  options.step = si(45.0, "deg");
  options.steps = 12;
  const auto found = optimise(plan, options, {}), again = optimise(plan, options, {});
  const auto text = plan_with_schedule(plan, found.schedule);
  EXPECT_EQ(text, plan_with_schedule(plan, again.schedule)) << "the same bytes";
  EXPECT_TRUE(text.starts_with("# a comment\n"));
  EXPECT_NE(text.find("\n# what it is\n[truth]\n"), std::string::npos);
  const auto best = load(text, "best.toml");
  ASSERT_EQ(best.schedule.size(), found.schedule.size());
  for (std::size_t s = 0; s < best.schedule.size(); ++s) {
    EXPECT_EQ(best.schedule[s].duration, found.schedule[s].duration);
    EXPECT_EQ(best.schedule[s].axes.at("outer").value, found.schedule[s].axes.at("outer").value);
  }
  const auto predicted = predict_model(best, ten_terms);
  ASSERT_EQ(predicted.parameters.size(), found.estimate.parameters.size());
  EXPECT_EQ(predicted.covariance.values, found.estimate.covariance.values);
}

TEST_F(Predict, OptimisesRatesWhereThePlanHasRates) {
  const std::string along =
      "mount_pitch = {hold = \"-90 deg\"}\n";  // the input axis along the table's: a rate tells the scale
  const auto plan =
      load(head("sdof_gyro", "rate_table") +
           "[[schedule]]\nlabel = \"still\"\nduration = \"10 min\"\ntable = {hold = \"0 deg\"}\n" + along +
           "[[schedule]]\nlabel = \"turn\"\nduration = \"10 min\"\ntable = {rate = \"5 deg/s\"}\n" + along + truth +
           "range = \"20 deg/s\"\n");
  OptimiseOptions options;
  options.terms = {"D_F", "scale_factor_error"};
  options.steps = 12;
  const auto found = optimise(plan, options, {});
  EXPECT_EQ(told(found.estimate, "A-optimal"), "2 of 2");
  double fastest = 0.0;
  for (const auto& segment : found.schedule)
    if (const auto& motion = segment.axes.at("table"); motion.kind == Motion::Kind::rate)
      fastest = std::max(fastest, std::abs(motion.value));
  EXPECT_GT(fastest, 0.0);
  EXPECT_LE(fastest, si(20.0, "deg/s")) << "what the instrument measures";
}

TEST_F(Predict, RampsAreNotOptimised) {
  const auto plan =
      load(head("fiber_optic_gyro", "thermal_chamber") +
           "[[schedule]]\nlabel = \"soak\"\nduration = \"1 h\"\nchamber = {dwell = \"0 degC\"}\n[[schedule]]"
           "\nlabel = \"up\"\nchamber = {ramp = \"1 K/min\", to = \"60 degC\"}\n[truth]\n"
           "angle_random_walk = \"0.005 deg/sqrt(h)\"\n");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"up", "chamber"}, .pattern = "only holds"},
                      [&] { optimise(plan, {}, {}); }));
}

TEST_F(Predict, RefusesUnknownTermsAndTimesAllAtOnce) {
  const auto plan = load(head("sdof_gyro", "two_axis_table") + six_faces("5 min") + truth);
  OptimiseOptions options;
  options.terms = {"D_X"};
  options.total_time = -1.0;
  options.step = 0.0;
  const Refused refusal = refusal_of([&] { optimise(plan, options, {}); });
  EXPECT_EQ(refusal.problems.size(), 3u);
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input,
              std::vector<Asked>{{.values = {"D_X"}}, {.pattern = "total time"}, {.pattern = "step between positions"}},
              refusal));
  options = {};
  options.step = si(400.0, "deg");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "step between positions"}, [&] {
    optimise(plan, options, {});
  })) << "one position would be left";
  options = {};
  options.total_time = 1.0;
  options.terms = ten_terms;
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "too short for any two motions"}, [&] {
    optimise(plan, options, {});
  })) << "too short for anything";
}

/// Every motion survives the way through the text.
TEST_F(Predict, ScheduleTextIsReadBackBitForBit) {
  const auto plan =
      load(head("sdof_gyro", "rate_table") +
           "[[schedule]]\nlabel = \"a \\\"b\\\"\"\nduration = \"10.1 min\"\nrun = [1, 2]\ntable = {hold = "
           "\"33.3 deg\"}\n[[schedule]]\nlabel = \"c\"\nduration = \"7 s\"\nrun = [1, 2]\ntable = {rate = "
           "\"-0.7 deg/s\"}\n[[schedule]]\nlabel = \"d\"\nduration = \"1 min\"\nrun = 2\ntable = {sine = "
           "{amplitude = \"1.7 deg\", frequency = \"0.3 Hz\", phase = \"20 deg\"}}\n[[schedule]]\nlabel = "
           "\"e\"\nduration = \"9 min\"\nrun = 2\ntable = {slew = \"3 deg/s\", to = \"11 deg\"}\n" +
           truth);
  const auto again = load(plan_with_schedule(plan, plan.schedule), "again.toml");
  ASSERT_EQ(again.schedule.size(), plan.schedule.size());
  for (std::size_t s = 0; s < plan.schedule.size(); ++s) {
    const auto &a = plan.schedule[s], &b = again.schedule[s];
    EXPECT_EQ(a.label, b.label);
    EXPECT_EQ(a.duration, b.duration);
    EXPECT_EQ(a.run, b.run);
    const auto &x = a.axes.at("table"), &y = b.axes.at("table");
    EXPECT_EQ(x.kind, y.kind);
    EXPECT_EQ(x.value, y.value);
    EXPECT_EQ(x.to, y.to);
    EXPECT_EQ(x.amplitude, y.amplitude);
    EXPECT_EQ(x.frequency, y.frequency);
    EXPECT_EQ(x.phase, y.phase);
  }
}

/// Ready plans whose parameters are no terms of the model, and two whose parameters are.
class OptimisedReadyPlan : public testing::TestWithParam<const char*> {};

TEST_P(OptimisedReadyPlan, MakesNoParameterWorseAndIsOneThatTheRigCanDo) {
  const Plan plan = load_plan(std::string(TUMBLE_SOURCE_DIR) + "/plans/" + GetParam() + ".toml", {});
  OptimiseOptions options;
  options.steps = 12;
  options.step = si(45.0, "deg");
  const auto found = optimise(plan, options, {});
  EXPECT_TRUE(find_rig(plan.rig_kind).refusals(found.schedule, plan.rig).empty());
  Plan best = plan;
  best.schedule = found.schedule;
  const auto before = predict(plan), after = predict(best);
  std::size_t limited = 0;
  for (const auto& parameter : before.parameters)
    limited += std::ranges::find(plan.limits, parameter.name, &LimitEntry::parameter) != plan.limits.end();
  for (std::size_t i = 0; i < before.parameters.size(); ++i) {
    const auto& name = before.parameters[i].name;
    if (limited > 0 && std::ranges::find(plan.limits, name, &LimitEntry::parameter) == plan.limits.end()) continue;
    const auto* same = find_parameter(after, name);
    ASSERT_NE(same, nullptr) << name;
    EXPECT_LE(standard_uncertainty(after, static_cast<std::size_t>(same - after.parameters.data())),
              1.00001 * standard_uncertainty(before, i))
        << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Plans, OptimisedReadyPlan,
                         testing::Values("gyro_scale_factor", "rlg_north_finder", "accelerometer_tumble",
                                         "polar_axis_tumble", "accelerometer_four_position"),
                         [](const auto& entry) { return std::string(entry.param); });

// The plan reaches 4 g; the arm could give 53.7 g, which nobody said that the gyro bears.
TEST_F(Predict, TheInstrumentIsNotLoadedBeyondItsRangeOrThePlan) {
  const Plan plan = load_plan(std::string(TUMBLE_SOURCE_DIR) + "/plans/sdof_gyro_centrifuge.toml", {});
  const auto greatest = [&](const Schedule& schedule) {
    Plan one = plan;
    one.schedule = schedule;
    double most = 0.0;
    for (const auto& felt : prediction::felt_over(one)) most = std::max(most, norm(felt.specific_force));
    return most;
  };
  OptimiseOptions options;
  options.steps = 0;
  options.terms = {"D_F", "D_OO"};  // of all of them the search takes a minute
  EXPECT_LE(greatest(optimise(plan, options, {}).schedule), 1.01 * greatest(plan.schedule));
}

}  // namespace
}  // namespace tumble
