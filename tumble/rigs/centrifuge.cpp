#include "tumble/rigs/chain/arm.hpp"

namespace tumble::rigs {
namespace {

/// The fixture at the end of the arm: x radially outwards, y along the motion of a positive rate, z upwards.
std::vector<Joint> joints(const Settings& options, const ErrorValues& errors) {
  return {arm_joint(options), end_joint(options, errors)};
}

const Machine& machine() {
  static const Machine machine{
      .axes = {arm_axis()},
      .geometry = arm_geometry("the fixture"),
      .imperfections = joined({axis_imperfections({"arm"}), drive_imperfections({"arm"}), arm_imperfections()}),
      .joints = joints,
      .check = check_arm};
  return machine;
}

std::vector<Axis> axes() { return axes_of(machine()); }
std::vector<Option> options() { return options_of(machine()); }
std::vector<RigError> errors(const Settings& options) { return errors_of(machine(), options); }
Reference reference(const RigRun& run) { return reference_of(machine(), run); }
std::vector<std::string> refusals(const Schedule& schedule, const Settings& options) {
  return refusals_of(machine(), schedule, options);
}

}  // namespace

extern const Rig centrifuge;
const Rig centrifuge{
    .name = "centrifuge",
    .summary = "precision centrifuge: the instrument at the end of an arm that turns about the vertical",
    .axes = axes,
    .options = options,
    .errors = errors,
    .reference = reference,
    .refusals = refusals};

}  // namespace tumble::rigs
