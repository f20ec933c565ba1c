#include "tumble/sim/simulate.hpp"

#include <gtest/gtest.h>

#include "tumble/methods/method.hpp"

namespace tumble {
namespace {

TEST(Simulate, gives_the_same_samples_in_blocks_as_at_once) {
  const Plan plan = find_method("fog_thermal_bias").trial(1).evidence.plan;
  const Recording whole = simulate(plan, 5, {});
  Recording joined;
  simulate(
      plan, 5, 777,
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
