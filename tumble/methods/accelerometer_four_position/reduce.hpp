#pragma once

#include <array>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/methods/accelerometer_four_position/design.hpp"

/// From positions to coefficients over temperature with their covariance.
namespace tumble::accelerometer_four_position {

/// One cell: value, standard uncertainty by all sources together, and by the output noise alone [SI].
struct CellResult {
  std::array<double, quantities> value{};
  std::array<double, quantities> sd{}, noise_sd{};
};

/// Variances that were estimated together.
struct Estimated {
  std::vector<Matrix> shares;   ///< covariance of the parameters for a unit of each
  Matrix covariance;            ///< of the variances
  std::vector<double> freedom;  ///< of the mean square that shows each [1]
};

struct Reduced {
  std::vector<Quantity> active;  ///< bias and scale factor error; with four positions all
  std::vector<CellResult> cells;
  std::array<Polynomial, quantities> polynomial;
  std::vector<double> parameters;  ///< plain polynomials, one quantity after the other [SI per K^j]
  Matrix covariance;
  std::vector<Estimated> estimated;
  std::vector<SourceCovariance> sources;
  std::array<double, quantities> repeatability{};  ///< sd of a cell beyond the known sources [SI]
  /// By how much the temperatures differ from the polynomial (rms beyond the repeats) [SI], and F; 0: not clearly.
  std::array<double, quantities> misfit{}, misfit_ratio{};
  bool repeated = false;             ///< some temperature was measured more than once
  bool repeatability_known = false;  ///< there are enough degrees of freedom to estimate it
  Fit fit;
};

/// Degrees of freedom of the variance v = w'C w of a combination of the parameters, from those of the estimated
/// variances s_c^2:
///
///   nu = 2 v^2/Var(v)                                                        (Welch and Satterthwaite)
///   sqrt(nu') = (8 sqrt(d) + d^2 sqrt(nu))/(8 + d^2)    where nu > d
///   1/d = sum_c V_c/d_c/sum_c V_c,  V_c = (dv/ds_c^2)^2 Var(s_c^2)
///
/// v is a known part and one with d degrees of freedom. Where the latter happens to be small, v is small and nu is
/// large: an interval of 95 % by nu holds the truth in 87 to 95 % of tests with d = 1 and in 93.5 to 95 % with d = 3,
/// one by nu' in 94.0 to 97.1 % and 94.7 to 95.5 %, with any share of the known part.
///
/// Given     weights  w, one a parameter
/// Returned  [1], at least 1; infinite where nothing was estimated
/// See       docs/decisions/094
double freedom_of(const Reduced& reduced, const std::vector<double>& weights);

/// Known noise where there are no data.
struct Expected {
  NoiseModel noise;         ///< of the output
  double turn_on_sd = 0.0;  ///< turn-on repeatability of the bias [m/s^2]
};

/// Positions -> cells by (3.5) -> polynomials (3.6) by generalised least squares, weights from the noise, the rig's
/// errors and the repeatability by restricted likelihood.
///
/// Given     order     highest power of T
///           two       the source's estimator, positions 1 and 3 alone
///           thermometer_sd [K]
///           expected  null: from measurements
Reduced reduce(const Bench& bench, std::size_t order, bool two, double thermometer_sd, const Expected* expected);

}  // namespace tumble::accelerometer_four_position
