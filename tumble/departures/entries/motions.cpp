#include <algorithm>
#include <cmath>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::entries {
namespace {

using Kind = Motion::Kind;

/// Axes of the rig that have a motion for which `wanted` holds.
std::vector<std::string> axes_with(const Plan& plan, bool (*wanted)(const Motion& motion)) {
  std::vector<std::string> axes;
  for (const Segment& segment : plan.schedule)
    for (const auto& [axis, motion] : segment.axes)
      if (wanted(motion) && std::ranges::find(axes, axis) == axes.end()) axes.push_back(axis);
  return axes;
}

bool oscillates(const Motion& motion) {
  return motion.kind == Kind::sine || motion.kind == Kind::sweep || motion.kind == Kind::random;
}
bool turns(const Motion& motion) { return motion.kind == Kind::rate && motion.value != 0.0; }
bool has_frequency(const Motion& motion) { return motion.kind == Kind::sine; }
bool stands(const Motion& motion) { return motion.kind == Kind::hold; }

std::vector<std::string> oscillating(const Plan& plan, const Recordings&) { return axes_with(plan, oscillates); }
std::vector<std::string> turning(const Plan& plan, const Recordings&) { return axes_with(plan, turns); }
std::vector<std::string> sines(const Plan& plan, const Recordings&) { return axes_with(plan, has_frequency); }

/// Axes that go from one angle to another and stop there.
std::vector<std::string> positioned(const Plan& plan, const Recordings&) {
  std::vector<std::string> axes = axes_with(plan, stands);
  std::erase_if(axes, [&](const std::string& axis) {
    if (plan.rig_kind.empty() || is_mount_axis(axis)) return true;
    for (const Axis& one : find_rig(plan.rig_kind).axes())
      if (one.name == axis && one.unit != "deg") return true;
    return std::ranges::none_of(plan.schedule, [&](const Segment& segment) {
      const auto found = segment.axes.find(axis);
      return found != segment.axes.end() && stands(found->second) && found->second.value != 0.0;
    });
  });
  return axes;
}

void edit_motions(Plan& plan, const std::string& axis, const std::function<void(Motion&)>& edit) {
  for (Segment& segment : plan.schedule)
    if (const auto found = segment.axes.find(axis); found != segment.axes.end()) edit(found->second);
}

void oscillate_more(Plan& plan, const Happening& what) {
  edit_motions(plan, what.target, [&](Motion& motion) {
    motion.amplitude *= 1.0 + what.size;
    for (double& density : motion.psd) density *= (1.0 + what.size) * (1.0 + what.size);
  });
}

void turn_faster(Plan& plan, const Happening& what) {
  edit_motions(plan, what.target, [&](Motion& motion) {
    if (turns(motion)) motion.value *= 1.0 + what.size;
  });
}

void oscillate_faster(Plan& plan, const Happening& what) {
  edit_motions(plan, what.target, [&](Motion& motion) {
    if (has_frequency(motion)) motion.frequency *= 1.0 + what.size;
  });
}

void turn_back(Plan& plan, const Happening& what) {
  edit_motions(plan, what.target, [](Motion& motion) {
    if (turns(motion) || stands(motion)) motion.value = -motion.value;
    if (oscillates(motion)) motion.phase += pi;
  });
}

/// All positions of an axis, except its zero, are off by as much: a wrong index.
void offset_positions(Plan& plan, const Happening& what) {
  edit_motions(plan, what.target, [&](Motion& motion) {
    if (stands(motion)) motion.value += what.size;
  });
}

void drift_positions(Plan& plan, const Happening& what) {
  double held = 0.0, before = 0.0;
  edit_motions(plan, what.target, [&](const Motion& motion) { held += stands(motion) ? 1.0 : 0.0; });
  edit_motions(plan, what.target, [&](Motion& motion) {
    if (stands(motion)) motion.value += what.size * before++ / std::max(held - 1.0, 1.0);
  });
}

/// Of vibration 1 %, of a table what it states, else 500 ppm: as the rigs of the catalogue begin.
double covered_amplitude(const Plan& plan, const Recordings&, const std::string&) {
  return rig_number(plan, "amplitude_sd", 500e-6);
}
double covered_rate(const Plan& plan, const Recordings&, const std::string&) {
  return std::max(rig_number(plan, "rate_error_sd", 1e-6), 1e-6);
}
double covered_frequency(const Plan&, const Recordings&, const std::string&) { return crystal; }
double covered_position(const Plan& plan, const Recordings&, const std::string&) {
  return std::max(rig_number(plan, "repeatability_sd", arcsecond), arcsecond);
}

}  // namespace

// NOLINTNEXTLINE(readability-function-size): a table, one entry after another
std::vector<Departure> of_motions() {
  return {{.name = "motion_amplitude",
           .summary = "an axis oscillates further than planned",
           .targets = oscillating,
           .told_by = {"level_differs_from_plan", "level_differs_from_reference", "vibration_differs_from_plan",
                       "force_differs_from_rig", "oscillation_recorded"},
           .unit = "%",
           .covered = covered_amplitude,
           .carry_out = oscillate_more},
          {.name = "motion_rate",
           .summary = "an axis turns faster than planned",
           .targets = turning,
           .told_by = {"turn_rate_recorded", "rates_differ_from_plan", "force_differs_from_rig",
                       "turns_do_not_fit_earth_rate"},
           .unit = "ppm",
           .covered = covered_rate,
           .carry_out = turn_faster},
          {.name = "motion_frequency",
           .summary = "an axis oscillates at a higher frequency than planned",
           .targets = sines,
           .told_by = {"frequency_differs_from_plan", "turn_rate_recorded", "clocks_disagree", "frequency_apart",
                       "oscillation_recorded"},
           .unit = "ppm",
           .covered = covered_frequency,
           .carry_out = oscillate_faster},
          {.name = "motion_sign",
           .summary = "an axis turns and stands in the other direction than planned",
           .targets =
               [](const Plan& plan, const Recordings& recordings) {
                 std::vector<std::string> axes = turning(plan, recordings);
                 for (const auto& axis : positioned(plan, recordings))
                   if (std::ranges::find(axes, axis) == axes.end()) axes.push_back(axis);
                 return axes;
               },
           .told_by = {"wrong_sign", "turn_rate_recorded", "angle_off_plan", "arm_turns_the_other_way",
                       "table_turns_the_other_way", "gyro_reversed", "rotation_reversed_by_scale_factor",
                       "rotation_reversed_by_gravity", "rotation_reversed_by_earth_rate", "turns_may_be_reversed",
                       "segment_reads_as_another", "positions_not_as_planned", "outputs_exchanged", "axes_mirrored",
                       "scale_factor_negative_in_set", "axis_moves_the_other_way"},
           .carry_out = turn_back},
          {.name = "positions_offset",
           .summary = "all positions of an axis are off by the same angle",
           .targets = positioned,
           .told_by = {"angle_off_plan", "rig_error_beyond_stated", "positions_off_circle", "encoder_zero_off_plan"},
           .unit = "arcsec",
           .covered = covered_index,
           .carry_out = offset_positions},
          {.name = "positions_drift",
           .summary = "the positions of an axis move away from the planned ones during the test",
           .targets = positioned,
           .told_by = {"angle_off_plan", "repeats_differ_more_than_positions", "output_drifts_with_time",
                       "positions_still_change"},
           .unit = "arcsec",
           .covered = covered_position,
           .carry_out = drift_positions}};
}

}  // namespace tumble::entries
