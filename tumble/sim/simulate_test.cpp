#include "tumble/sim/simulate.hpp"

#include <gtest/gtest.h>

#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble {
namespace {

/// Two power-ups of a fibre-optic gyro with every kind of noise in a chamber.
Plan plan_with_noise() {
  Plan plan;
  plan.instrument_model = "fiber_optic_gyro";
  plan.sample_rate = 2.0;
  plan.rig_kind = "thermal_chamber";
  plan.rig = defaults(find_rig(plan.rig_kind).options());
  for (const int run : {1, 2})
    plan.schedule.push_back({"dwell", 900.0, run, {{"chamber", {.kind = Motion::Kind::dwell, .value = 300.0}}}});
  plan.truth = defaults(truth_options(find_model(plan.instrument_model)));
  for (const char* name : {"angle_random_walk", "bias_instability", "rate_random_walk", "quantization_noise",
                           "markov_sd", "rate_ramp", "turn_on_repeatability", "A1_0"})
    plan.truth.set_number(name, 1e-6, Unit{});
  return plan;
}

TEST(Simulate, gives_the_same_samples_in_blocks_as_at_once) {
  const Plan plan = plan_with_noise();
  const Recording whole = simulate(plan, 5, {});
  Recording joined;
  simulate(plan, 5, 777,
           [&](const Recording& block) {
             if (joined.channels.empty()) {
               joined = block;
               return;
             }
             for (std::size_t c = 0; c < block.channels.size(); ++c) {
               auto& to = joined.channels[c];
               const auto& from = block.channels[c];
               EXPECT_LE(from.values.size(), 777u);
               EXPECT_NEAR(from.timeline.start, to.timeline.time(to.values.size()), 1e-6);
               to.values.insert(to.values.end(), from.values.begin(), from.values.end());
             }
           },
           {});
  ASSERT_EQ(joined.channels.size(), whole.channels.size());
  ASSERT_EQ(joined.marks.size(), whole.marks.size());
  std::size_t bytes = 0;
  for (std::size_t c = 0; c < whole.channels.size(); ++c) {
    EXPECT_EQ(joined.channels[c].name, whole.channels[c].name);
    EXPECT_EQ(joined.channels[c].values, whole.channels[c].values) << whole.channels[c].name;
    bytes += whole.channels[c].values.size() * sizeof(double);
  }
  EXPECT_EQ(simulated_size(plan), bytes);
}

}  // namespace
}  // namespace tumble
