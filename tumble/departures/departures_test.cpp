#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tumble/departures/departure.hpp"
#include "tumble/departures/judgement.hpp"
#include "tumble/language/texts.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

Motion held(double angle) { return {.kind = Motion::Kind::hold, .value = si(angle, "deg")}; }

/// An accelerometer on a dividing head without errors and noise: three positions of 60 s.
Plan three_positions() {
  Plan plan = trial_plan("accelerometer_tumble", find_method("accelerometer_tumble").options(),
                         "pendulous_accelerometer", "dividing_head", 2.0);
  plan.rig.set_flag("ideal", true);
  set_truth(plan, "bias", 2.0, "mg");
  for (const auto& [label, angle] : {std::pair{"a", 0.0}, {"b", 90.0}, {"c", 180.0}})
    plan.schedule.push_back({label, 60.0, 1, {{"head", held(angle)}}});
  return plan;
}

const Channel& channel(const SimulatedTest& test, const char* name) {
  return *find_channel(test.evidence.recordings.front(), name);
}

SimulatedTest departed(const SimulatedTest& test, const char* name, double size = 0.0) {
  const Departure& departure = find_departure(name);
  return with_departure(test, departure, targets_of(departure, test).at(0), size, 1);
}

double mean_of(const Channel& channel, double begin, double end) {
  double sum = 0.0;
  const std::size_t first = index_at(channel, begin), last = index_at(channel, end);
  for (std::size_t i = first; i < last; ++i) sum += channel.values[i];
  return sum / static_cast<double>(last - first);
}

TEST(DepartureCatalogue, NamesAreUniqueAndCodesAreThoseOfFindings) {
  const auto codes = texts_of(Language::english, "finding");
  std::set<std::string> names;
  for (const Departure& departure : departure_catalogue()) {
    EXPECT_TRUE(names.insert(departure.name).second) << departure.name;
    EXPECT_NE(std::string(departure.summary), "") << departure.name;
    EXPECT_TRUE(departure.carry_out != nullptr || departure.record != nullptr) << departure.name << " does nothing";
    EXPECT_TRUE(*departure.unit == '\0' || departure.covered != nullptr) << departure.name << ": a unit without a size";
    for (const std::string& code : departure.told_by)
      EXPECT_TRUE(codes.contains(code) || codes.contains(code + ".one")) << departure.name << ": " << code;
  }
  for (const Unseen& unseen : unseen_departures()) EXPECT_TRUE(names.contains(unseen.departure)) << unseen.departure;
}

/// A fibre-optic gyro with noise on a rate table: at rest, turning, at rest; no stamp is a round number.
Plan one_turn() {
  Plan plan = trial_plan("gyro_scale_factor", find_method("gyro_scale_factor").options(), "fiber_optic_gyro",
                         "rate_table", 3.7);
  set_truth(plan, "angle_random_walk", 0.05, "deg/sqrt(h)");
  const Motion turning{.kind = Motion::Kind::rate, .value = si(20.0, "deg/s")};
  for (const auto& [label, motion] : {std::pair{"a", held(0.0)}, {"b", turning}, {"c", held(0.0)}}) {
    plan.schedule.push_back({label, 120.0, 1, {{"table", motion}}});
    plan.schedule.back().axes["mount_pitch"] = held(-30.0);
  }
  return plan;
}

bool has_other_samples(const SimulatedTest& before, const SimulatedTest& after) {
  if (other_channels_differ(before, after)) return true;
  return std::ranges::any_of(before.evidence.recordings.front().channels, [&](const Channel& sound) {
    const Channel* now = find_channel(after.evidence.recordings.front(), sound.name);
    return now == nullptr || now->values != sound.values;
  });
}

// A departure may pass by one test: rounded stamps were round before. Of two unlike tests it changes one.
TEST(DepartureCatalogue, EachChangesATestThatItAppliesTo) {
  std::set<std::string> applied, changed;
  for (const SimulatedTest& test : {simulated_test(three_positions(), 1), simulated_test(one_turn(), 1)})
    for (const Departure& departure : departure_catalogue())
      for (const std::string& target : targets_of(departure, test)) {
        const double size = sizes_of(departure, test, target).back();
        applied.insert(departure.name);
        if (has_other_samples(test, with_departure(test, departure, target, size, 1))) changed.insert(departure.name);
      }
  EXPECT_EQ(changed, applied);
  EXPECT_GT(applied.size(), 40u);
}

TEST(DepartureCatalogue, HappensToTheOutputThatThePlanNames) {
  Plan plan = trial_plan("static_bias", find_method("static_bias").options(), "triad", "rate_table", 2.0);
  plan.truth.set_word("sensors", "gyros");
  plan.schedule.push_back({"rest", 60.0, 1, {}});
  const auto targets = [&] { return targets_of(find_departure("bias_step"), simulated_test(plan, 1)); };
  EXPECT_EQ(targets(), std::vector<std::string>{"gyro_x"});
  plan.channels["signal"] = {{"gyro_z", {}}};
  EXPECT_EQ(targets(), (std::vector<std::string>{"gyro_x", "gyro_z"}));
}

// Without a measured value the plan's gravity is that of the formula, which a departure of nothing leaves as it is.
TEST(Departure, GravityWrongBeginsAtThatOfTheSite) {
  const SimulatedTest test = simulated_test(three_positions(), 1), after = departed(test, "gravity_wrong", 0.0);
  EXPECT_EQ(channel(after, "accelerometer").values, channel(test, "accelerometer").values);
}

TEST(Departure, RepeatsWithItsSeedAndLeavesThePlanAlone) {
  const SimulatedTest test = simulated_test(three_positions(), 1);
  const SimulatedTest once = departed(test, "samples_zero"), again = departed(test, "samples_zero");
  EXPECT_EQ(channel(once, "accelerometer").values, channel(again, "accelerometer").values);
  const SimulatedTest moved = departed(test, "positions_offset", 0.1);
  EXPECT_EQ(moved.evidence.plan.schedule[1].axes.at("head").value, si(90.0, "deg"));
  EXPECT_EQ(moved.carried_out.schedule[1].axes.at("head").value, si(90.0, "deg") + 0.1);
}

TEST(Departure, OrderChangedMovesTheLabelsWithThePositions) {
  const SimulatedTest test = simulated_test(three_positions(), 1), after = departed(test, "order_changed");
  std::vector<std::string> labels;
  for (const Mark& mark : after.evidence.recordings.front().marks) labels.push_back(mark.label);
  EXPECT_NE(labels, (std::vector<std::string>{"a", "b", "c"}));
  std::ranges::sort(labels);
  EXPECT_EQ(labels, (std::vector<std::string>{"a", "b", "c"}));
}

TEST(Departure, PositionMissingTakesItsSamplesAndItsMark) {
  const SimulatedTest test = simulated_test(three_positions(), 1), after = departed(test, "position_missing");
  EXPECT_EQ(after.evidence.recordings.front().marks.size(), 2u);
  EXPECT_EQ(channel(after, "accelerometer").values.size(), 240u);
}

TEST(Departure, ClockFastMovesStampsAndMarks) {
  const SimulatedTest test = simulated_test(three_positions(), 1), after = departed(test, "clock_fast", 1e-3);
  EXPECT_DOUBLE_EQ(mean_rate(channel(after, "accelerometer")), 2.0 / 1.001);
  EXPECT_DOUBLE_EQ(after.evidence.recordings.front().marks[1].begin, 60.06);
  EXPECT_EQ(after.evidence.plan.sample_rate, 2.0);
}

TEST(Departure, ThatDriftsGrowsFromNothing) {
  const SimulatedTest test = simulated_test(three_positions(), 1);
  const SimulatedTest after = departed(test, "level_drifts", si(1.0, "deg"));
  const auto &before = channel(test, "accelerometer").values, &now = channel(after, "accelerometer").values;
  EXPECT_DOUBLE_EQ(now.front(), before.front());
  EXPECT_GT(std::abs(now.back() - before.back()), 0.0);
}

// Mean of a step of 1 m/s^2 that comes between 0.3 and 0.7 of the record: nothing of it in the first quarter, all of it in the last.
TEST(Departure, BiasStepIsThereAtTheEndOnly) {
  const SimulatedTest test = simulated_test(three_positions(), 1), after = departed(test, "bias_step", 1.0);
  const Channel &before = channel(test, "accelerometer"), &now = channel(after, "accelerometer");
  EXPECT_DOUBLE_EQ(mean_of(now, 0.0, 45.0), mean_of(before, 0.0, 45.0));
  EXPECT_NEAR(mean_of(now, 135.0, 180.0) - mean_of(before, 135.0, 180.0), 1.0, 1e-9);  // rounding of 90 samples
}

TEST(Departure, AddsToATestWhoseSamplesHaveSomethingMore) {
  const Plan plan = three_positions();
  SimulatedTest made = simulated_test(plan, 1);
  made.evidence.recordings.front().channels.front().values[7] += 0.5;
  const SimulatedTest test = simulated_test(made.evidence, made.truth, 1);
  ASSERT_NE(test.simulated, nullptr);  // its encoder has the very samples of the simulation
  const SimulatedTest after = departed(test, "positions_offset", 0.1),
                      plain = departed(simulated_test(plan, 1), "positions_offset", 0.1);
  EXPECT_NEAR(channel(after, "accelerometer").values[7] - channel(plain, "accelerometer").values[7], 0.5, 1e-12);
}

TEST(Departure, OfThePlanIsRefusedWhereNoPlanWasCarriedOut) {
  SimulatedTest test = simulated_test(three_positions(), 1);
  test.simulated = nullptr;
  const Departure& departure = find_departure("order_changed");
  EXPECT_TRUE(targets_of(departure, test).empty());
  EXPECT_THROW(with_departure(test, departure, "", 0.0, 1), Error);
  EXPECT_FALSE(targets_of(find_departure("warm_up"), test).empty());
}

TEST(Departure, TruthIsThatOfTheTerms) {
  const SimulatedTest test = simulated_test(three_positions(), 1);
  const auto bias = std::ranges::find(test.truth, "bias", &std::pair<std::string, double>::first);
  ASSERT_NE(bias, test.truth.end());
  EXPECT_DOUBLE_EQ(bias->second, si(2.0, "mg"));
}

}  // namespace
}  // namespace tumble
