#pragma once

#include "tumble/methods/fog_thermal_bias/solve.hpp"

namespace tumble::fog_thermal_bias {

/// Looks beside the model in all power-ups together: the output is late against the temperature, goes up and down with the
/// time of the record, or settles along it. Each is a column beside those of the answer, with a level for each
/// power-up, under the noise found; the most significant one is said.
///
/// Given: interval between the averages [s]
Findings beside_model(const Answer& answer, double interval);

}  // namespace tumble::fog_thermal_bias
