
#include "tumble/rigs/chain/machine.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::rigs::rate_table {
namespace {

using namespace chain;

using Kind = Motion::Kind;

/// The axis of the table is z, pointing to the given azimuth and elevation. At angle 0, x is horizontal and to the
/// right of that azimuth: a vertical axis and azimuth 0 give x east, y north.
std::vector<Joint> joints(const Settings& options, const ErrorValues&) {
  return {{.fixed = about_x(options.number("axis_elevation") - half_pi) * about_z(-options.number("axis_azimuth")),
           .axis = 0,
           .about = About::z}};
}

const Machine& machine() {
  static const Machine machine{
      .axes = {{"table",
                "angle of the table about its axis, right-handed",
                {Kind::hold, Kind::slew, Kind::rate, Kind::sine, Kind::sweep},
                "1000 deg/s",
                "500 deg/s^2"}},
      .geometry =
          {quantity("axis_elevation", "deg").otherwise("90 deg").says("elevation of the table's axis; 90 deg: upwards"),
           quantity("axis_azimuth", "deg")
               .otherwise("0 deg")
               .says("azimuth of the table's axis, from north to the east")},
      .imperfections =
          joined({axis_imperfections({"table"}), drive_imperfections({"table"}), oscillation_imperfections({"table"})}),
      .joints = joints};
  return machine;
}

}  // namespace

extern const Rig rate_table = rig_of<machine>(
    "rate_table", "single-axis rate table; its axis may be tilted, for example parallel to the Earth's");

}  // namespace tumble::rigs::rate_table
