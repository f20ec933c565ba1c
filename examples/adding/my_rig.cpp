// A rig of one's own: a stand with one level axis, on which an instrument is tilted from position to position.

#include "tumble/rigs/chain/machine.hpp"

namespace tumble::rigs::my_rig {
namespace {

using namespace chain;

/// The axis of the stand is y, level. At angle 0, z is up; a positive angle turns z towards x, so that
/// f = (-g sin th, 0, g cos th).
std::vector<Joint> joints(const Settings&, const ErrorValues&) { return {{.axis = 0, .about = About::y}}; }

const Machine& machine() {
  static const Machine machine{.axes = {{"tilt",
                                         "angle of the stand about its axis, right-handed",
                                         {Motion::Kind::hold, Motion::Kind::slew},
                                         "10 deg/s",
                                         "20 deg/s^2"}},
                               .geometry = {},
                               .imperfections = axis_imperfections({"tilt"}),
                               .joints = joints};
  return machine;
}

}  // namespace

extern const Rig my_rig = rig_of<machine>("my_rig", "tilt stand: an instrument turned about a level axis");

}  // namespace tumble::rigs::my_rig
