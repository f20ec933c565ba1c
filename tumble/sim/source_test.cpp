#include "tumble/sim/source.hpp"

#include <gtest/gtest.h>

#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

TEST(Source, MakesTheSamePortionsWhateverIsAskedFor) {
  std::vector<std::pair<std::size_t, std::size_t>> made;
  Source source({Channel{}, Channel{}}, 23, 8, [&](std::size_t first, const Samples& out) {
    made.emplace_back(first, out.front().size());
    for (std::size_t i = 0; i < out.front().size(); ++i) {
      out[0][i] = static_cast<double>(first + i);
      out[1][i] = -out[0][i];
    }
  });
  std::vector<double> a(23), b(23);
  std::size_t at = 0;
  for (const std::size_t size : {3, 1, 12, 0, 7}) {
    source.next({std::span(a).subspan(at, size), std::span(b).subspan(at, size)});
    at += size;
  }
  for (std::size_t i = 0; i < 23; ++i) {
    EXPECT_EQ(a[i], static_cast<double>(i));
    EXPECT_EQ(b[i], -static_cast<double>(i));
  }
  const std::vector<std::pair<std::size_t, std::size_t>> whole{{0, 8}, {8, 8}, {16, 7}};
  EXPECT_EQ(made, whole);
}

/// An IMU on a table that turns and oscillates, without anything that would hide a rounding.
Plan moving_plan() {
  Plan plan;
  plan.instrument_model = "imu";
  plan.sample_rate = 300.0;
  plan.site = Site{.latitude = 0.6};
  plan.rig_kind = "three_axis_table";
  plan.rig = defaults(find_rig(plan.rig_kind).options());
  plan.rig.set_flag("ideal", true);
  plan.schedule = {{"turn", 30.0, 1, {{"outer", {.kind = Motion::Kind::rate, .value = 0.7}}}},
                   {"swing", 7.001, 1, {{"inner", {.kind = Motion::Kind::sine, .amplitude = 0.1, .frequency = 0.9}}}}};
  plan.truth = defaults(truth_options(find_model(plan.instrument_model)));
  plan.truth.set_integer("oversampling", 3);
  plan.truth.set_number("gyro_angle_random_walk", 1e-6, Unit{});
  return plan;
}

TEST(Simulate, MovingSamplesDoNotDependOnTheBlocks) {
  const Plan plan = moving_plan();
  const Recording whole = simulate(plan, 5, {});
  for (const std::size_t size : {777, 5461, 8192}) {
    std::vector<std::vector<double>> joined(whole.channels.size());
    simulate(plan, 5, size,
             [&](const Recording& block) {
               for (std::size_t c = 0; c < block.channels.size(); ++c)
                 joined[c].insert(joined[c].end(), block.channels[c].values.begin(), block.channels[c].values.end());
             },
             {});
    for (std::size_t c = 0; c < whole.channels.size(); ++c)
      EXPECT_EQ(joined[c], whole.channels[c].values) << whole.channels[c].name << " in blocks of " << size;
  }
}

std::vector<std::string> problems_of(const Plan& plan) {
  try {
    simulate(plan, 1, {});
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_input);
    return texts_of(error.problems);
  }
  return {};
}

TEST(Simulate, RefusesAllAtOnce) {
  Plan plan = moving_plan();
  plan.truth.set_word("gyro_output", "count");
  plan.truth.set_word("accelerometer_output", "count");
  plan.schedule.push_back({"short", 1e-4, 2, {}});
  plan.schedule[1].axes["inner"].frequency = 451.0;
  const auto problems = problems_of(plan);
  const std::vector<std::string> starts{"[truth] gyro_output = \"count\" needs",
                                        "[truth] accelerometer_output = \"count\" needs",
                                        "segment 'swing': inner at 451", "run 2 is shorter than a sample"};
  for (const auto& start : starts)
    EXPECT_TRUE(std::any_of(problems.begin(), problems.end(), [&](const auto& p) { return p.starts_with(start); }))
        << start;
  EXPECT_EQ(problems.size(), starts.size());
}

TEST(Simulate, RefusesMoreSamplesThanCanBe) {
  Plan plan = moving_plan();
  for (auto& segment : plan.schedule) segment.duration = 1e300;
  EXPECT_EQ(problems_of(plan).size(), 1u);
}

}  // namespace
}  // namespace tumble
