#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace tumble::results {

/// The axis, 0 to 2 for x to z, that the name of a channel says: by a part x, y or z ("gyro.x", "gyro_x_dps", "GyrX",
/// "imu0_acc_x") or by one that joins it with the sensor ("ax_g", "wx", "accelx", "xacc"). Nothing where no part says
/// one, or parts say different ones.
std::optional<std::size_t> axis_named(std::string_view channel);

}  // namespace tumble::results
