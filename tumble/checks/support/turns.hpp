#pragma once

#include <optional>

#include "tumble/core/channel.hpp"

namespace tumble::support {

/// An angle that begins again after each turn, such as 0 to 360 deg, as one that goes on: what stands at 359.99 deg and
/// at 0 by turns is at rest, and neither far from its neighbours nor at the end of a range. Absent where a channel does
/// not.
std::optional<Channel> without_wraps(const Channel& channel);

}  // namespace tumble::support
