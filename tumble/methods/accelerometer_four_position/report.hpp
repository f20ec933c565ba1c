#pragma once

#include "tumble/methods/accelerometer_four_position/reduce.hpp"

namespace tumble::accelerometer_four_position {

/// Powers of T that the temperatures of a test allow, at most `wanted` (auto: 2).
std::size_t order_of(const Settings& settings, const Bench& bench);

/// Parameters, budget, tables, curves and findings.
Estimate described(const Bench& bench, const Reduced& reduced, const Settings& settings, bool measured);

/// Specific force from the output, docs/equations (3.4) for one channel: A = (1 + dK(T)) N/(K_m H) - nabla(T).
OutputModel model_of(const Bench& bench, const Evidence& evidence, const Estimate& estimate);

}  // namespace tumble::accelerometer_four_position
