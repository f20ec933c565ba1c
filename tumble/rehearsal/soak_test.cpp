#include "tumble/rehearsal/soak.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/rehearsal/made_station.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

Plan plan_of(const std::string& name) { return load_plan(TUMBLE_SOURCE_DIR "/plans/" + name + ".toml", {}); }

TEST(Soak, LastsUntilTheWidestStepOfAChamberHasComeDown) {
  // -20 to 60 degC and 4 K of its own heat, by 14 min
  EXPECT_NEAR(soak_time_of(plan_of("fog_thermal_bias"), 1e-3), 840.0 * std::log(84.0 / 1e-3), 1e-6);
  EXPECT_EQ(soak_time_of(plan_of("dtg_centrifuge"), 1e-3), 0.0) << "no chamber";
}

TEST(Soak, IsTheTimeWithoutPowerOfAStationThatIsMade) {
  EXPECT_GT(station_for(plan_of("fog_thermal_bias")).power.off_time, 2.0 * hour);
  EXPECT_EQ(station_for(plan_of("dtg_centrifuge")).power.off_time, 5.0);
}

}  // namespace
}  // namespace tumble
