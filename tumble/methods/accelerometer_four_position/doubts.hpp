#pragma once

#include "tumble/methods/accelerometer_four_position/positions.hpp"

namespace tumble::accelerometer_four_position {

/// Doubts about the test that its records raise: thermometers the set points of the plan, counts a converter without dead band.
Findings doubts_about(const Bench& bench);

}  // namespace tumble::accelerometer_four_position
