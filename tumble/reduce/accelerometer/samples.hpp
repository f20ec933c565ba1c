#pragma once

#include <string>
#include <vector>

#include "tumble/reduce/accelerometer/scale_factor.hpp"

/// Faults that show in single samples of a segment.
namespace tumble::accelerometer {

/// Where counts are off by a power of two, and what to do: empty where they are not.
std::vector<std::string> overflows_of(const Evidence& evidence, const Normalised& found);

/// "'a', 'b' and 3 more"
std::string quoted(const std::vector<std::string>& labels);

}  // namespace tumble::accelerometer
