#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/recording.hpp"

namespace tumble {

/// Names of channels that play a role unless a plan names others, the first before the others: "gyro_x"; "gyro.x", as
/// logs call it.
std::vector<std::string> names_of_role(std::string_view role);
/// The channel with the first of these names that the recording has. Null: none.
const Channel* find_role(const Recording& recording, std::string_view role);

/// The axis, 0 to 2 for x to z, that the name of a channel says: by a part x, y or z ("gyro.x", "gyro_x_dps", "GyrX",
/// "imu0_acc_x") or by one that joins it with the sensor ("ax_g", "wx", "accelx", "xacc"). Nothing where no part says
/// one, or parts say different ones.
std::optional<std::size_t> axis_named(std::string_view channel);

/// A channel that probably plays a role, although its name does not say so.
struct ProposedRole {
  std::string role;     ///< "gyro_x"
  std::string channel;  ///< "wx"
};

/// Name and kind of a channel, which are known before its samples are read.
struct NamedKind {
  std::string name;
  QuantityKind kind = QuantityKind::other;
};

/// Proposed roles of an IMU for three gyros or accelerometers whose names say the three axes, each once. Empty where
/// they have these roles already, or where the axes are not clear.
std::vector<ProposedRole> proposed_roles(const std::vector<NamedKind>& channels);

}  // namespace tumble
