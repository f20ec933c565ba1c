#include "tumble/methods/testing/trials.hpp"

#include <string>
#include <utility>

#include "tumble/reduce/sdof_gyro_support/testing/positions.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::sdof_gyro_static {
namespace {

/// 6 faces, 12 edges and 8 corners in a mixed order, the first again at the end, on a two-axis table.
Trial trial(std::uint64_t seed) {
  Plan plan = sdof_gyro_support::trial_plan("sdof_gyro_static", find_method("sdof_gyro_static").options(),
                                            "two_axis_table", 1.0);
  for (const auto& position : sdof_gyro_support::cube_positions())
    plan.schedule.push_back(sdof_gyro_support::at(position, 100.0));
  plan.schedule.push_back(plan.schedule.front());
  plan.schedule.back().label += " again";
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  for (const char* name : {"D_F", "D_I", "D_O", "D_S", "D_IO", "D_OS", "D_IS", "D_II", "D_SS"})
    trial.truth.emplace_back(name, plan.truth.number(name));
  return trial;
}

constexpr std::pair<const char*, double> second_coefficients[] = {{"D_F", -0.7},  {"D_I", -1.4},   {"D_O", 0.3},
                                                                  {"D_S", 2.2},   {"D_IO", -0.05}, {"D_OS", 0.04},
                                                                  {"D_IS", -0.1}, {"D_II", -0.06}, {"D_SS", 0.05}};

/// A current, coefficients of the other sign and larger noise; the positions backwards and forwards at opposite
/// azimuths with the misalignments and a drift as parameters, on a table whose axis stands askew at another site, with
/// samples missing.
Trial second_trial(std::uint64_t seed) {
  Plan plan = sdof_gyro_support::trial_plan("sdof_gyro_static", find_method("sdof_gyro_static").options(),
                                            "two_axis_table", 2.0);
  plan.site = Site{si(-33.9, "deg"), si(18.4, "deg"), 1700.0, {}};
  plan.rig.set_number("outer_azimuth", si(37.0, "deg"), Unit::parse("deg"));
  plan.settings.set_flag("drift", true);
  for (const auto& [name, value] : second_coefficients)
    set_truth(plan, name, value,
              std::string(name) == "D_F"      ? "deg/h"
              : std::string(name).size() == 3 ? "deg/h/g"
                                              : "deg/h/g^2");
  set_truth(plan, "angle_random_walk", 0.004, "deg/sqrt(h)");
  set_truth(plan, "bias_instability", 0.006, "deg/h");
  set_truth(plan, "torquer_scale_factor", -510.0, "deg/h/mA");
  plan.truth.set_word("output", "current");
  set_setting(plan, "torquer_scale_factor", -510.0, "deg/h/mA");
  auto positions = sdof_gyro_support::cube_positions();
  for (std::size_t k = positions.size(); k-- > 0;) plan.schedule.push_back(sdof_gyro_support::at(positions[k], 80.0));
  for (auto& position : positions) {  // the other azimuth: f is as before
    position.label += " turned";
    position.outer = -position.outer;
    position.inner += si(180.0, "deg");
    plan.schedule.push_back(sdof_gyro_support::at(position, 80.0));
  }
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  lose_samples(trial.evidence.recordings.front(), seed, 30);
  for (const auto& [name, value] : second_coefficients) trial.truth.emplace_back(name, plan.truth.number(name));
  trial.truth.emplace_back("drift_rate", 0.0);
  return trial;
}

}  // namespace

extern const Trials trials{trial, second_trial};

}  // namespace tumble::sdof_gyro_static
