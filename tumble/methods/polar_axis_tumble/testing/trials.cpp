#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/reduce/sdof_gyro_support/testing/positions.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::polar_axis_tumble {
namespace {

Segment position(double roll, double angle, double duration) {
  return {fmt::format("{} {:g}", roll > 0.0 ? "O north" : "O south", angle),
          duration,
          1,
          {{"head", {.kind = Motion::Kind::hold, .value = si(angle, "deg")}},
           {"mount_roll", {.kind = Motion::Kind::hold, .value = si(roll, "deg")}}}};
}

Trial conducted(const Plan& plan, std::uint64_t seed) {
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  const auto d = [&](const char* name) { return plan.truth.number(name); };
  for (const char* name : {"D_I", "D_O", "D_S", "D_IO", "D_OS", "D_IS"}) trial.truth.emplace_back(name, d(name));
  trial.truth.emplace_back("D_SS_minus_D_II", d("D_SS") - d("D_II"));
  return trial;
}

/// Sixteen angles in a mixed order about the Earth's axis, with O along it and against it.
Trial trial(std::uint64_t seed) {
  Plan plan = sdof_gyro_support::trial_plan("polar_axis_tumble", find_method("polar_axis_tumble").options(),
                                            "dividing_head", 1.0);
  plan.rig.set_number("axis_elevation", plan.site->latitude, Unit::parse("deg"));
  for (const double roll : {90.0, -90.0})
    for (int k = 0; k < 16; ++k)
      plan.schedule.push_back(position(roll, 22.5 * static_cast<double>((5 * k) % 16), 100.0));
  return conducted(plan, seed);
}

/// In the southern hemisphere, all drifts with the other sign, twelve positions a sense in falling order, one sample of
/// 23 missing, on a clock that does not begin at zero.
Trial second_trial(std::uint64_t seed) {
  Plan plan = sdof_gyro_support::trial_plan("polar_axis_tumble", find_method("polar_axis_tumble").options(),
                                            "dividing_head", 1.0);
  plan.site->latitude = si(-41.0, "deg");
  plan.rig.set_number("axis_elevation", plan.site->latitude, Unit::parse("deg"));
  for (const char* name : {"D_F", "D_I", "D_O", "D_S", "D_IO", "D_OS", "D_IS", "D_SS"})
    plan.truth.set_number(name, -1.3 * plan.truth.number(name), Unit::parse("deg/h"));
  plan.truth.set_number("D_II", si(-0.2, "deg/h/g^2"), Unit::parse("deg/h/g^2"));
  for (const double roll : {-90.0, 90.0})
    for (int k = 0; k < 12; ++k) plan.schedule.push_back(position(roll, 330.0 - 30.0 * k, 140.0));
  Trial trial = conducted(plan, seed);
  Recording& recording = trial.evidence.recordings.front();
  for (Mark& mark : recording.marks) mark.begin += 5000.5;
  for (Channel& channel : recording.channels) {
    channel.timeline.start += 5000.5;
    for (std::size_t i = 11; i < channel.values.size(); i += 23) channel.values[i] = std::nan("");
  }
  return trial;
}

}  // namespace

extern const Trials trials{trial, second_trial};

}  // namespace tumble::polar_axis_tumble
