
#include "tumble/rigs/chain/machine.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::rigs::three_axis_table {
namespace {

using namespace chain;

using Kind = Motion::Kind;

/// Outer axis z, middle axis y, inner axis x: the fixture is turned from the level axes by yaw, pitch and roll.
std::vector<Joint> joints(const Settings& options, const ErrorValues& errors) {
  return {{.fixed = about_z(half_pi - options.number("inner_azimuth")), .axis = 0, .about = About::z},
          {.fixed = about_x(errors(error_names::middle_to_outer)), .axis = 1, .about = About::y},
          {.fixed = about_z(errors(error_names::inner_to_middle)), .axis = 2, .about = About::x}};
}

const Machine& machine() {
  static const Machine machine{
      .axes = {{"outer",
                "angle of the outer axis, right-handed about z (upwards)",
                {Kind::hold, Kind::slew, Kind::rate, Kind::sine, Kind::sweep},
                "200 deg/s",
                "100 deg/s^2"},
               {"middle",
                "angle of the middle axis, right-handed about y",
                {Kind::hold, Kind::slew, Kind::rate, Kind::sine, Kind::sweep},
                "300 deg/s",
                "200 deg/s^2"},
               {"inner",
                "angle of the inner axis, right-handed about x",
                {Kind::hold, Kind::slew, Kind::rate, Kind::sine, Kind::sweep},
                "500 deg/s",
                "500 deg/s^2"}},
      .geometry = {quantity("inner_azimuth", "deg")
                       .otherwise("90 deg")
                       .says("azimuth of the inner axis when all angles are 0, from north to the east")},
      .imperfections = joined({axis_imperfections({"outer", "middle", "inner"}),
                               drive_imperfections({"outer", "middle", "inner"}),
                               oscillation_imperfections({"outer", "middle", "inner"}),
                               {{quantity("orthogonality_sd", "arcsec")
                                     .at_least(0)
                                     .otherwise("2 arcsec")
                                     .says("angle between neighbouring axes less 90 deg"),
                                 {error_names::middle_to_outer, error_names::inner_to_middle}}}}),
      .joints = joints};
  return machine;
}

}  // namespace

extern const Rig three_axis_table =
    rig_of<machine>("three_axis_table", "three-axis table: outer axis upwards, then a middle and an inner one");

}  // namespace tumble::rigs::three_axis_table
