#pragma once

#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/methods/fog_thermal_bias/departures.hpp"
#include "tumble/methods/fog_thermal_bias/fit.hpp"
#include "tumble/methods/fog_thermal_bias/levels.hpp"

namespace tumble::fog_thermal_bias {

/// Everything identified at one assumed sensor lag.
struct Answer {
  std::vector<RunData> runs;
  std::vector<Candidate> candidates;
  std::size_t chosen = 0;
  std::size_t largest = 0;           ///< candidate whose terms `fit` holds; see largest_supported()
  std::vector<std::size_t> columns;  ///< of the largest candidate
  NoiseModel noise;
  LinearFit fit;  ///< values by the chosen candidate, zero elsewhere; covariance by the largest
  std::vector<double> degrees_of_freedom;  ///< of each parameter's variance
  Misfit misfit;
  LevelFit levels;                    ///< without `bias` where the start temperatures are too few
  Findings uneven;                    ///< what is not alike in or between the power-ups
  std::vector<std::size_t> not_used;  ///< two_stage: fitted runs that do not determine the coefficients alone
};

/// Averages the runs, finds their noise, chooses the orders by AICc and fits the chosen model and the largest that the
/// data support, with the sensors' lag `lag` [s]. Throws Error::bad_data for too few start temperatures, too short or
/// constant recordings.
Answer solve(const Evidence& evidence, const std::vector<Term>& terms, double lag, const Progress& progress);

/// The coefficients, then the polynomial of the levels, at another lag less the answer [SI]: what the lag's uncertainty
/// does to them. Given: lag [s].
std::vector<double> shift_by_lag(const Evidence& evidence, const std::vector<Term>& terms, const Answer& answer,
                                 double lag);

}  // namespace tumble::fog_thermal_bias
