#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/methods/fog_thermal_bias/solve.hpp"

namespace tumble::fog_thermal_bias {

/// The answer as an estimate: coefficients with covariance and budget, the standard deviations before and after, and
/// L_0 over start temperature with the turn-on repeatability.
Estimate describe(const Evidence& evidence, const std::vector<Term>& terms, const Answer& answer);

}  // namespace tumble::fog_thermal_bias
