#include "tumble/rigs/capabilities.hpp"

#include <algorithm>

#include "tumble/rigs/rig.hpp"

namespace tumble {
namespace {

/// The axes that the rig moves, without how the instrument is mounted and the air about it.
std::vector<Axis> own_axes(const Plan& plan) {
  auto axes = find_rig(plan.rig_kind).axes();
  std::erase_if(axes, [](const Axis& axis) { return is_mount_axis(axis.name) || axis.unit == "degC"; });
  return axes;
}

}  // namespace

bool is_fixed_on_arm(const Plan& plan) {
  if (plan.rig_kind.empty()) return false;
  const auto axes = own_axes(plan);
  return axes.size() == 1 && axes.front().name == "arm" && plan.rig.has("radius");
}

bool is_laid_by_hand(const Plan& plan) {
  return !plan.rig_kind.empty() && find_rig(plan.rig_kind).axes().size() == 3 && own_axes(plan).empty();
}

bool has_one_index_axis(const Plan& plan) {
  if (plan.rig_kind.empty()) return false;
  const auto axes = own_axes(plan);
  return axes.size() == 1 && std::ranges::all_of(axes.front().motions, [](Motion::Kind kind) {
           return kind == Motion::Kind::hold || kind == Motion::Kind::slew;
         });
}

}  // namespace tumble
