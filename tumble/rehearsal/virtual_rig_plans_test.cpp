#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tumble/rehearsal/virtual_rig.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {
namespace {

using Kind = Motion::Kind;
using Values = std::vector<std::vector<double>>;

/// The ready plans that can be simulated, cut to so many samples that the test stays short.
std::vector<Plan> plans_to_carry_out() {
  std::vector<Plan> plans;
  for (const auto& entry : std::filesystem::directory_iterator(TUMBLE_SOURCE_DIR "/plans")) {
    Plan plan = load_plan(entry.path().string(), {});
    if (plan.rig_kind.empty() || plan.instrument_model.empty() || plan.schedule.empty() || plan.truth.texts().empty())
      continue;
    const double most = 5e4 / oversampling_of(plan) / plan.sample_rate;  // [s]
    double time = 0.0;
    std::size_t segments = 0;
    while (segments < plan.schedule.size() && (segments == 0 || time < most))
      time += plan.schedule[segments++].duration;
    plan.schedule.resize(segments);
    plans.push_back(std::move(plan));
  }
  std::ranges::sort(plans, {}, &Plan::file);
  return plans;
}

/// Where the axes are when a run begins: as simulate() takes it.
std::map<std::string, double> begins_of(const Segment& segment) {
  std::map<std::string, double> values;
  for (const auto& [axis, motion] : segment.axes)
    if (motion.kind == Kind::hold || motion.kind == Kind::dwell) values[axis] = motion.value;
  return values;
}

void append(const std::vector<VirtualSamples>& blocks, Values& values) {
  for (const auto& block : blocks) {
    values.resize(block.channels.size());
    for (std::size_t c = 0; c < values.size(); ++c)
      values[c].insert(values[c].end(), block.channels[c].values.begin(), block.channels[c].values.end());
  }
}

/// Commands follow the plan; samples are asked for in between.
Values carried_out(const Plan& plan, std::uint64_t seed, SampleTiming timing) {
  VirtualRig rig(plan, seed, timing);
  Values values;
  for (const auto& run : power_ups(plan.schedule, plan.sample_rate)) {
    rig.place(run.begin, begins_of(run.segments.front()));
    rig.power(run.begin, true);
    double since = 0.0;
    for (const auto& segment : run.segments) {
      EXPECT_EQ(rig.carry_out(run.begin + since, segment), "") << plan.file << ", " << segment.label;
      append(rig.samples(run.begin + since + 0.37 * segment.duration), values);
      since += segment.duration;
      append(rig.samples(run.begin + since), values);
    }
    rig.power(run.begin + since, false);
    append(rig.samples(run.begin + since), values);
  }
  return values;
}

TEST(VirtualRigPlans, ToldWhatAPlanTellsWhenItTellsItGivesTheBytesOfSimulate) {
  std::size_t compared = 0;
  for (const Plan& plan : plans_to_carry_out()) {
    const Recording simulated = simulate(plan, 7, {});
    const Values values = carried_out(plan, 7, SampleTiming::final);
    ASSERT_EQ(values.size(), simulated.channels.size()) << plan.file;
    for (std::size_t c = 0; c < values.size(); ++c) {
      const auto& expected = simulated.channels[c].values;
      ASSERT_EQ(values[c].size(), expected.size()) << plan.file;
      const auto differs = std::ranges::mismatch(values[c], expected);
      EXPECT_TRUE(differs.in1 == values[c].end())
          << plan.file << ", " << simulated.channels[c].name << ", sample " << differs.in1 - values[c].begin() << " of "
          << expected.size() << ": " << *differs.in1 << " - " << *differs.in2 << " = " << *differs.in1 - *differs.in2;
      ++compared;
    }
  }
  EXPECT_GE(compared, 60u);
}

}  // namespace
}  // namespace tumble
