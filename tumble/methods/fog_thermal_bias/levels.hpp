#pragma once

#include <limits>
#include <vector>

#include "tumble/methods/fog_thermal_bias/fit.hpp"

namespace tumble::fog_thermal_bias {

/// Levels of the fitted runs at power-on over their start temperatures,
///
///   m_r - g_r' a = sum_j bias_j (T_0r - T_ref)^j + d_r + e_r
///
/// with d_r the turn-on scatter, its variance by restricted likelihood, and e_r the noise of a level.
struct LevelFit {
  std::vector<double> bias;                ///< [SI]
  Matrix of_levels;                        ///< H: d bias / d level [powers x runs]
  Matrix of_coefficients;                  ///< -H G: d bias / d coefficient [powers x q]
  Matrix noise;                            ///< covariance of `bias` by e_r and by the coefficients [SI]
  Matrix scatter;                          ///< covariance of `bias` by d_r [SI]
  std::vector<double> degrees_of_freedom;  ///< of the variances of `bias`
  double turn_on_variance = 0.0;           ///< of d_r [(rad/s)^2]
  double noise_variance = 0.0;             ///< mean of that of the levels by everything else [(rad/s)^2]
  double total_freedom = 0.0;              ///< of the sum of the two
  /// [rad/s] lower end of the 95 % interval of the sd of d_r, where one run may not belong to the others and is not counted;
  /// NaN: all belong together.
  double least_turn_on = std::numeric_limits<double>::quiet_NaN();
};

/// Generalised least squares with the covariance of the levels: that of the coefficients is common to all runs.
///
/// Given     levels            one a run, of columns that `parameters` and `covariance` [SI] belong to
///           start_difference  T_0 - T_ref of each run [K]
///           powers            of the start temperature; fewer than the runs by two or more
///           inflation         by which the noise is larger than its model says
///           known_turn_on     variance of d_r [(rad/s)^2]; negative: to be found
/// Returned  no `bias` where the start temperatures do not determine it
LevelFit fit_levels(const std::vector<RunLevel>& levels, const std::vector<double>& parameters,
                    const Matrix& covariance, const std::vector<double>& start_difference, std::size_t powers,
                    double inflation, double known_turn_on = -1.0);

}  // namespace tumble::fog_thermal_bias
