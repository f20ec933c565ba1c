#include "tumble/rigs/chain/arm.hpp"

namespace tumble::rigs::centrifuge {
namespace {

using namespace chain;

/// The fixture at the end of the arm: x radially outwards, y along the motion of a positive rate, z upwards.
std::vector<Joint> joints(const Settings& options, const ErrorValues& errors) {
  return {arm_joint(options), end_joint(options, errors)};
}

const Machine& machine() {
  static const Machine machine{
      .axes = {arm_axis()},
      .geometry = arm_geometry("the fixture"),
      .imperfections = joined({axis_imperfections({"arm"}), drive_imperfections({"arm"}), arm_imperfections()}),
      .joints = joints};
  return machine;
}

}  // namespace

extern const Rig centrifuge = rig_of<machine>(
    "centrifuge", "precision centrifuge: the instrument at the end of an arm that turns about the vertical");

}  // namespace tumble::rigs::centrifuge
