#include <algorithm>

#include "tumble/departures/entries/edits.hpp"
#include "tumble/departures/entries/entries.hpp"
#include "tumble/earth/earth.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::entries {
namespace {

constexpr auto speeds = {"max_rate",        "max_acceleration",        "arm_max_rate",   "arm_max_acceleration",
                         "table_max_rate",  "table_max_acceleration",  "outer_max_rate", "outer_max_acceleration",
                         "middle_max_rate", "middle_max_acceleration", "inner_max_rate", "inner_max_acceleration",
                         "ramp_limit",      "oven_ramp_limit"};
constexpr auto elevations = {"axis_elevation", "outer_elevation", "shake_elevation"};
constexpr auto azimuths = {"axis_azimuth", "outer_azimuth", "shake_azimuth", "arm_azimuth"};

std::vector<std::string> if_it_has(const Plan& plan, std::initializer_list<const char*> options) {
  return rig_has(plan, options) ? std::vector<std::string>{""} : std::vector<std::string>{};
}

std::vector<std::string> with_speed(const Plan& plan, const Recordings&) {
  return rig_has(plan, {"move_time"}) ? std::vector<std::string>{""} : if_it_has(plan, speeds);
}

/// A vibration has a highest acceleration too, which is no speed of the rig.
void move_slowly(Plan& plan, const Happening& what) {
  scale_in_rig(plan, "move_time", 1.0 + what.size);
  if (plan.rig.has("shake_elevation")) return;
  for (const char* option : speeds) scale_in_rig(plan, option, 1.0 / (1.0 + what.size));
}

/// A tenth: drives are specified by what they reach at least, and settle for as long as a plan's settling says.
double covered_slowness(const Plan&, const Recordings&, const std::string&) { return 0.1; }

double covered_level(const Plan& plan, const Recordings&, const std::string&) {
  return std::max(rig_number(plan, "level_sd", 2.0 * arcsecond), 0.1 * arcsecond);
}
double covered_azimuth(const Plan& plan, const Recordings&, const std::string&) {
  return std::max(rig_number(plan, "azimuth_sd", 10.0 * arcsecond), arcsecond);
}

void tilt(Plan& plan, const Happening& what) {
  for (const char* option : elevations) add_to_rig(plan, option, what.size);
}
void turn_base(Plan& plan, const Happening& what) {
  for (const char* option : azimuths) add_to_rig(plan, option, what.size);
}

double covered_cross_motion(const Plan& plan, const Recordings&, const std::string&) {
  return std::max(rig_number(plan, "cross_motion_sd", 0.02), 0.001);
}

/// The fixture's cross motion follows its main motion, by a factor that is drawn with this standard deviation.
void move_across(Plan& plan, const Happening& what) {
  const double stated = plan.rig.number("cross_motion_sd");
  if (stated > 0.0)
    scale_in_rig(plan, "cross_motion_sd", what.size / stated);
  else
    add_to_rig(plan, "cross_motion_sd", what.size);
}

/// In the laboratory gravity is known to 30 ug from its latitude and height (docs/equations: normal gravity), a map
/// gives the latitude to 10 arcsec.
double covered_gravity(const Plan& plan, const Recordings&, const std::string&) {
  return std::max(rig_number(plan, "gravity_sd", 30.0 * micro_g), micro_g);
}
double covered_latitude(const Plan& plan, const Recordings&, const std::string&) {
  return plan.site ? plan.site->latitude_sd.value_or(10.0 * arcsecond) : 10.0 * arcsecond;
}

std::vector<std::string> with_site(const Plan& plan, const Recordings&) {
  return plan.site ? std::vector<std::string>{""} : std::vector<std::string>{};
}

}  // namespace

// NOLINTNEXTLINE(readability-function-size): a table, one entry after another
std::vector<Departure> of_rigs() {
  return {
      {.name = "rig_slow",
       .summary = "moves of the rig take longer than its plan says: lower speeds and accelerations",
       .targets = with_speed,
       .told_by = {"step_in_segment", "segment_still_changes", "segments_begin_unsettled", "segments_settle",
                   "segments_begin_in_last", "rates_do_not_settle", "move_off_rests", "soak_is_short", "move_not_over"},
       .unit = "%",
       .covered = covered_slowness,
       .carry_out = move_slowly},
      {.name = "level_off",
       .summary = "the base of the rig is tilted",
       .targets = [](const Plan& plan, const Recordings&) { return if_it_has(plan, elevations); },
       .told_by = {"rig_error_beyond_stated", "tilt_of_the_rig", "opposite_tilts", "different_tilts", "tilt_beyond_rig",
                   "position_disagrees"},
       .unit = "arcsec",
       .covered = covered_level,
       .carry_out = tilt},
      {.name = "level_drifts",
       .summary = "the base of the rig tilts more and more during the test",
       .targets = [](const Plan& plan, const Recordings&) { return if_it_has(plan, elevations); },
       .told_by = {"rig_error_beyond_stated", "output_drifts_with_time", "repeats_differ_more_than_positions",
                   "different_tilts", "positions_still_change"},
       .unit = "arcsec",
       .covered = covered_level,
       .carry_out = tilt,
       .drifts = true},
      {.name = "azimuth_off",
       .summary = "the base of the rig looks in another direction",
       .targets = [](const Plan& plan, const Recordings&) { return if_it_has(plan, azimuths); },
       .told_by = {"rig_error_beyond_stated", "wrong_horizontal_rate", "turns_do_not_fit_earth_rate",
                   "axis_not_the_earths"},
       .unit = "arcsec",
       .covered = covered_azimuth,
       .carry_out = turn_base},
      {.name = "cross_motion",
       .summary = "the fixture of a shaker moves across, in phase with its main motion",
       .targets = [](const Plan& plan, const Recordings&) { return if_it_has(plan, {"cross_motion_sd"}); },
       .told_by = {"rig_error_beyond_stated"},
       .unit = "%",
       .covered = covered_cross_motion,
       .carry_out = move_across},
      {.name = "gravity_wrong",
       .summary = "gravity at the site differs from the plan's",
       .targets = with_site,
       .told_by = {"gravity_of_another_place", "accelerometers_do_not_fit_plan", "turns_do_not_fit_gravity"},
       .unit = "ug",
       .covered = covered_gravity,
       .carry_out = [](Plan& plan, const Happening& what) { plan.site->gravity = gravity(*plan.site) + what.size; }},
      {.name = "latitude_wrong",
       .summary = "the latitude of the site differs from the plan's",
       .targets = with_site,
       .told_by = {"wrong_horizontal_rate", "earth_rate_differs", "turns_do_not_fit_earth_rate"},
       .unit = "arcsec",
       .covered = covered_latitude,
       .carry_out = [](Plan& plan, const Happening& what) { plan.site->latitude += what.size; }}};
}

}  // namespace tumble::entries
