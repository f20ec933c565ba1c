#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/fog_thermal_bias/solve.hpp"

namespace tumble::fog_thermal_bias {

/// One row per model tried, the chosen one marked (the source's Tables 2 to 4, with held-out scores).
Table models_table(const std::vector<Candidate>& candidates, std::size_t chosen, const Estimate& estimate);

/// One row per run: start temperature, L_0, sd before and after, whether it was held out.
/// Given: columns of the fit.
Table runs_table(const std::vector<RunData>& runs, const std::vector<std::size_t>& columns, const LinearFit& fit);

/// The noise that the residuals show.
Table noise_table(const NoiseModel& noise);

/// The averages before and after compensation, each run less its L_0, over time joined end to end.
/// Given: columns of the fit.
std::vector<Curve> residual_curves(const std::vector<RunData>& runs, const std::vector<std::size_t>& columns,
                                   const LinearFit& fit);

/// Weak spots: models that the profile cannot distinguish, T against dT/dt, gradient against dT/dt, misfit, few runs.
Findings findings_of(const Answer& answer, const Settings& settings);

}  // namespace tumble::fog_thermal_bias
