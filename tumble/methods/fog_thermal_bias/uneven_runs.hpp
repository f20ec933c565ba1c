#pragma once

#include "tumble/methods/fog_thermal_bias/solve.hpp"

namespace tumble::fog_thermal_bias {

/// Whether the output steps within a power-up, or settles after it, beyond what the model and its noise explain: the
/// columns of a step and of an exponential beside the residual of each run, by generalised least squares under the noise
/// of the answer. The most significant one is said.
/// Given: interval [s] of the averages.
Findings uneven_runs(const Answer& answer, double interval);

}  // namespace tumble::fog_thermal_bias
