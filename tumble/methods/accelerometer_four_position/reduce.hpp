#pragma once

#include <array>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/accelerometer_four_position/design.hpp"

/// From positions to coefficients over temperature with their covariance.
namespace tumble::accelerometer_four_position {

/// One cell: value, standard uncertainty by all sources together, and by the output noise alone [SI].
struct CellResult {
  std::array<double, quantities> value{};
  std::array<double, quantities> sd{}, noise_sd{};
};

struct Reduced {
  std::vector<Quantity> active;  ///< bias and scale factor error; with four positions all
  std::vector<CellResult> cells;
  std::array<Polynomial, quantities> polynomial;
  std::vector<double> parameters;  ///< plain polynomials, one quantity after the other [SI per K^j]
  Matrix covariance;
  std::vector<double> degrees_of_freedom;
  std::vector<SourceCovariance> sources;
  std::array<double, quantities> repeatability{};  ///< sd of a cell beyond the known sources [SI]
  /// By how much the temperatures differ from the polynomial (rms beyond the repeats) [SI], and F; 0: not clearly.
  std::array<double, quantities> misfit{}, misfit_ratio{};
  bool repeated = false;             ///< some temperature was measured more than once
  bool repeatability_known = false;  ///< there are enough degrees of freedom to estimate it
  Fit fit;
};

/// Known noise where there are no data.
struct Expected {
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
