#pragma once

#include "tumble/core/plan.hpp"

/// Capabilities of the rig of a plan, so that methods need not know rigs by name. Each answer follows from the axes
/// that the rig lists; a plan without a rig has none of these capabilities.
namespace tumble {

/// Whether the instrument is fixed to the end of an arm, whose turning it feels: the arm is the rig's only axis. The
/// rig's options then give `radius` and `lever_x`.
bool is_fixed_on_arm(const Plan& plan);

/// Whether the instrument is laid down by hand: the rig has no axis of its own.
bool is_laid_by_hand(const Plan& plan);

/// Whether one axis puts the instrument to angles, and can do nothing else: the zero of its scale is one error of all.
bool has_one_index_axis(const Plan& plan);

}  // namespace tumble
