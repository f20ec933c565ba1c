#pragma once

#include <vector>

#include "tumble/models/model.hpp"

namespace tumble::fiber_optic_gyro {

/// The coil in [truth]: `winding` and what goes with it.
std::vector<Option> coil_options();

/// The drift of heat on its way through the coil; null with `winding = "none"`. Given: step [s].
/// Throws Error::bad_input that lists all that is out of bounds.
History coil_drift(const Settings& truth, double step);

}  // namespace tumble::fiber_optic_gyro
