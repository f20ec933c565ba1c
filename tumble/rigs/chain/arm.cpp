#include "tumble/rigs/chain/arm.hpp"

#include "tumble/units/constants.hpp"

namespace tumble::chain {

MachineAxis arm_axis() {
  using Kind = Motion::Kind;
  return {"arm",
          "angle of the arm, counter-clockwise seen from above",
          {Kind::hold, Kind::slew, Kind::rate},
          "1200 deg/s",
          "30 deg/s^2",
          false};
}

std::vector<Option> arm_geometry(const std::string& end) {
  return {
      quantity("radius", "m")
          .above(0)
          .otherwise("1 m")
          .says("distance from the arm's axis to " + end + ", arm at rest"),
      quantity("stretch", "um/(rad/s)^2")
          .at_least(0)
          .otherwise("0 um/(rad/s)^2")
          .says("known growth of the radius per squared rate of the arm"),
      quantity("arm_azimuth", "deg").otherwise("90 deg").says("azimuth of the arm at angle 0, from north to the east")};
}

std::vector<Imperfection> arm_imperfections() {
  return {{quantity("radius_sd", "um").at_least(0).otherwise("20 um").says("radius at rest"), {error_names::radius}},
          {quantity("stretch_sd", "um/(rad/s)^2")
               .at_least(0)
               .otherwise("0.2 um/(rad/s)^2")
               .says("growth of the radius per squared rate of the arm"),
           {error_names::stretch_of_radius}}};
}

Joint arm_joint(const Settings& options) {
  return {.fixed = about_z(half_pi - options.number("arm_azimuth")), .axis = 0, .about = About::z};
}

Joint end_joint(const Settings& options, const ErrorValues& errors) {
  return {.offset = {options.number("radius") + errors(error_names::radius), 0.0, 0.0},
          .stretch = options.number("stretch") + errors(error_names::stretch_of_radius)};
}

}  // namespace tumble::chain
