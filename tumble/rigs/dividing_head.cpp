
#include "tumble/rigs/chain/machine.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::rigs::dividing_head {
namespace {

using namespace chain;

using Kind = Motion::Kind;

/// The axis of the head is z, pointing to the given azimuth and elevation. At angle 0, y is up as far as it can be and
/// x horizontal, so that with a level axis f = (g sin th, g cos th, 0).
std::vector<Joint> joints(const Settings& options, const ErrorValues&) {
  return {{.fixed = about_z(2.0 * half_pi) * about_x(options.number("axis_elevation") - half_pi) *
                    about_z(-options.number("axis_azimuth")),
           .axis = 0,
           .about = About::z}};
}

/// Errors of the divided circle.
std::vector<Imperfection> scale_imperfections() {
  return {{quantity("angle_once_sd", "arcsec")
               .at_least(0)
               .otherwise("0.5 arcsec")
               .says("error of the divided circle, once per turn"),
           {"angle error of head once per turn, cosine", "angle error of head once per turn, sine"}},
          {quantity("angle_twice_sd", "arcsec")
               .at_least(0)
               .otherwise("0.3 arcsec")
               .says("error of the divided circle, twice per turn"),
           {"angle error of head twice per turn, cosine", "angle error of head twice per turn, sine"}}};
}

const Machine& machine() {
  static const Machine machine{
      .axes = {{"head",
                "angle of the head about its axis, right-handed",
                {Kind::hold, Kind::slew},
                "10 deg/s",
                "20 deg/s^2"}},
      .geometry =
          {quantity("axis_elevation", "deg").otherwise("0 deg").says("elevation of the head's axis; 0 deg: level"),
           quantity("axis_azimuth", "deg")
               .otherwise("0 deg")
               .says("azimuth of the head's axis, from north to the east")},
      .imperfections = joined({axis_imperfections({"head"}), scale_imperfections()}),
      .joints = joints,
      .oven = true};
  return machine;
}

}  // namespace

extern const Rig dividing_head = rig_of<machine>(
    "dividing_head",
    "dividing head: an instrument turned about a horizontal axis from position to position, in an oven");

}  // namespace tumble::rigs::dividing_head
