#include "tumble/rigs/chain/arm.hpp"

namespace tumble::rigs::counter_rotating_centrifuge {
namespace {

using namespace chain;

using Kind = Motion::Kind;

/// The angle of the table counts from the arm; at angle 0 the fixture's x points radially outwards.
std::vector<Joint> joints(const Settings& options, const ErrorValues& errors) {
  Joint table = end_joint(options, errors);
  table.fixed =
      about_x(errors(error_names::table_tilt_about_arm)) * about_y(errors(error_names::table_tilt_across_arm));
  table.axis = 1;
  return {arm_joint(options), table};
}

const Machine& machine() {
  static const Machine machine{
      .axes = {arm_axis(),
               {"table",
                "angle of the table against the arm, counter-clockwise seen from above",
                {Kind::hold, Kind::slew, Kind::rate},
                "1200 deg/s",
                "30 deg/s^2",
                false}},
      .geometry = arm_geometry("the table's axis"),
      .imperfections = joined({axis_imperfections({"arm", "table"}),
                               drive_imperfections({"arm", "table"}),
                               arm_imperfections(),
                               {{quantity("table_tilt_sd", "arcsec")
                                     .at_least(0)
                                     .otherwise("10 arcsec")
                                     .says("tilt of the table's axis against the arm's, in each of two directions"),
                                 {error_names::table_tilt_about_arm, error_names::table_tilt_across_arm}}}}),
      .joints = joints};
  return machine;
}

}  // namespace

extern const Rig counter_rotating_centrifuge = rig_of<machine>(
    "counter_rotating_centrifuge", "precision centrifuge with a table at the end of its arm that turns against it");

}  // namespace tumble::rigs::counter_rotating_centrifuge
