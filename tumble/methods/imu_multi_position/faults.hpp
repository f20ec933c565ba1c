#pragma once

#include <optional>

#include "tumble/core/plan.hpp"
#include "tumble/methods/imu_multi_position/fit.hpp"

namespace tumble::imu_multi_position {

/// Accelerometers in another unit than they say: |f| at rest is 1, 100 or 1000/9.8 times gravity. Throws
/// Error::bad_data that names the unit it looks like. Counts may have any scale.
void check_force_unit(const Session& session, const Matrix3& matrix);

/// Gyros in another unit than they say, or whose axes are not those of the accelerometers: exchanged, reversed,
/// left-handed. Throws Error::bad_data that names the channels and the remedy. The rotations compare the triads with
/// each other only: a reversal of both does not show.
void check_gyros(const Session& session, const Matrix3& matrix);

/// Direction up [1] at the first rest, by the setting `up` or the plan of a rig by hand; null: not known.
std::optional<Vector3> planned_up(const Plan& plan);

/// The first direction is opposite to the planned one: accelerometers that show gravity instead of the specific force.
/// Throws Error::bad_data. Gyros do not show it: both ends of a turn are reversed.
void check_up(Vector3 first, Vector3 planned);

}  // namespace tumble::imu_multi_position
