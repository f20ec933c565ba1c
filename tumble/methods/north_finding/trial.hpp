#pragma once

#include <cstdint>

#include "tumble/methods/method.hpp"

namespace tumble::methods::north {

Trial trial(std::uint64_t seed);

}  // namespace tumble::methods::north
