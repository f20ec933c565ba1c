#pragma once

#include <cstdint>

#include "tumble/methods/method.hpp"

namespace tumble::north_finding {

Trial trial(std::uint64_t seed);

}  // namespace tumble::north_finding
