
#include "tumble/rigs/chain/machine.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::rigs::two_axis_table {
namespace {

using namespace chain;

using Kind = Motion::Kind;

/// x along the outer axis, z along the inner one at angle 0. The defaults give x east, y north, z up.
std::vector<Joint> joints(const Settings& options, const ErrorValues& errors) {
  const Rotation base =
      about_y(-options.number("outer_elevation")) * about_z(half_pi - options.number("outer_azimuth"));
  return {{.fixed = base, .axis = 0, .about = About::x},
          {.fixed = about_y(errors(error_names::inner_to_outer)), .axis = 1, .about = About::z}};
}

const Machine& machine() {
  static const Machine machine{.axes = {{"outer",
                                         "angle of the outer axis, right-handed about x",
                                         {Kind::hold, Kind::slew, Kind::rate, Kind::sine, Kind::sweep},
                                         "200 deg/s",
                                         "200 deg/s^2"},
                                        {"inner",
                                         "angle of the inner axis, right-handed about z",
                                         {Kind::hold, Kind::slew, Kind::rate, Kind::sine, Kind::sweep},
                                         "500 deg/s",
                                         "500 deg/s^2"}},
                               .geometry = {quantity("outer_elevation", "deg")
                                                .otherwise("0 deg")
                                                .says("elevation of the outer axis; 0 deg: level, 90 deg: upwards"),
                                            quantity("outer_azimuth", "deg")
                                                .otherwise("90 deg")
                                                .says("azimuth of the outer axis, from north to the east")},
                               .imperfections = joined({axis_imperfections({"outer", "inner"}),
                                                        drive_imperfections({"outer", "inner"}),
                                                        oscillation_imperfections({"outer", "inner"}),
                                                        {{quantity("orthogonality_sd", "arcsec")
                                                              .at_least(0)
                                                              .otherwise("2 arcsec")
                                                              .says("angle between the axes less 90 deg"),
                                                          {error_names::inner_to_outer}}}}),
                               .joints = joints};
  return machine;
}

}  // namespace

extern const Rig two_axis_table =
    rig_of<machine>("two_axis_table", "two-axis table: an outer axis that carries an inner one at right angles");

}  // namespace tumble::rigs::two_axis_table
