#include "tumble/rigs/capabilities.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tumble/rigs/rig.hpp"

namespace tumble {
namespace {

/// The rigs of the catalogue of which `capability` holds, with their options as they are by default.
std::vector<std::string> able(bool (*capability)(const Plan&)) {
  std::vector<std::string> names;
  for (const Rig* rig : rig_catalogue()) {
    Plan plan;
    plan.rig_kind = rig->name;
    plan.rig = defaults(rig->options());
    if (capability(plan)) names.emplace_back(rig->name);
  }
  return names;
}

TEST(Capabilities, EachHoldsForTheRigThatIsBuiltSo) {
  EXPECT_EQ(able(is_fixed_on_arm), std::vector<std::string>{"centrifuge"});
  EXPECT_EQ(able(is_laid_by_hand), std::vector<std::string>{"by_hand"});
  EXPECT_EQ(able(has_one_index_axis), std::vector<std::string>{"dividing_head"});
}

TEST(Capabilities, APlanWithoutARigHasNone) {
  const Plan plan;
  EXPECT_FALSE(is_fixed_on_arm(plan) || is_laid_by_hand(plan) || has_one_index_axis(plan));
}

}  // namespace
}  // namespace tumble
