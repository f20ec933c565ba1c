#pragma once

#include "tumble/methods/method.hpp"

namespace tumble::methods::channels {

/// An IMU on a two-axis table, its accelerometers on a dividing head and its gyros on a rate table before; all counted.
Trial trial(std::uint64_t seed);

}  // namespace tumble::methods::channels
