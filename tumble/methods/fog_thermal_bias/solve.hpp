#pragma once

#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/methods/fog_thermal_bias/fit.hpp"

namespace tumble::fog_thermal_bias {

/// Everything identified at one assumed sensor lag.
struct Answer {
  std::vector<RunData> runs;
  std::vector<Candidate> candidates;
  std::size_t chosen = 0;
  NoiseModel noise;
  LinearFit fit;
  std::vector<double> degrees_of_freedom;  ///< of each parameter's variance
  std::vector<std::size_t> not_used;       ///< two_stage: fitted runs that do not determine the coefficients alone
};

/// Averages the runs, finds their noise, chooses the orders on held-out runs and fits the chosen model, the sensors'
/// lag taken as `lag` [s]. Throws Error::bad_data for too few start temperatures, too short or constant recordings.
Answer solve(const Evidence& evidence, const std::vector<Term>& terms, double lag, const Progress& progress);

/// The chosen columns fitted at another lag less the answer: what the lag's uncertainty does to the coefficients
/// [SI]. Given: lag [s].
std::vector<double> shift_by_lag(const Evidence& evidence, const std::vector<Term>& terms, const Answer& answer,
                                 double lag);

}  // namespace tumble::fog_thermal_bias
