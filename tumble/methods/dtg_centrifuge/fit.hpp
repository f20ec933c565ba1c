#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/math/regression/mixed_model.hpp"
#include "tumble/methods/dtg_centrifuge/effects.hpp"

/// From observations to levels, and across the levels, docs/equations (1.13).
namespace tumble::dtg_centrifuge {

/// Quantities of one fit, with their covariance by source.
struct Quantities {
  std::vector<double> value;  ///< [SI]
  MixedFit fit;               ///< covariance, sources, degrees of freedom of functions
};

/// Part of the observations that is fitted: p + i q of the levels, or their size alone where the phase is not known.
enum class Take { both_parts, size };

/// The lag of a loop as a quantity of the fit, beyond the one that the lines are corrected for, in units of the lag that
/// `shift` is of.
struct LagColumn {
  std::vector<Complex> shift = {};  ///< of each observation by a lag of one unit; empty: none
  double expected = 0.0, sd = 1.0;  ///< what else is known of it
};

/// p_1, q_1, p_2, q_2 ... (or K_1, K_2 ...), with one shift of all levels for each power-up.
///
/// The white noise is that of the parts about their mean. Where its level differs between the rates significantly
/// (0.1 % of a chi-square of Bartlett's), each level has its own.
///
/// Given     lag  empty: the loop is known. Otherwise its lag is a quantity too, the last
Quantities fit_levels(const std::vector<Observation>& observations, const std::vector<Effect>& effects,
                      std::size_t levels, Take take, bool unbiased, const LagColumn& lag, Findings& findings);

/// Mean over all observations of Z_h/a^h, real and imaginary part, and the lag where there is a column of it.
Quantities fit_harmonic(const std::vector<Observation>& observations, const std::vector<Effect>& effects, int harmonic,
                        const LagColumn& lag);

/// Order of p and q in a: p(a) = p_0 + p_2 a^2 + ..., docs/equations (1.13), and with both orientations of the spin
/// axis p_0 = D_x + D_xz f_Z.
struct Order {
  int powers = 0;  ///< of a^2
  double aicc = 0.0, chi_square = 0.0;
  bool chosen = false;
};

/// p and q as polynomials in a.
struct Polynomial {
  std::vector<Order> tried;
  int powers = 0;
  bool automatic = false;  ///< nobody stated the order
  bool both_orientations = false;
  std::size_t parts = 2;      ///< p and q, or K alone
  std::vector<double> value;  ///< of p: p_0, (D_xz,) p_2, p_4; then those of q; then the lag, if it is a quantity
  Matrix of_levels;           ///< d value / d level quantities
  bool has_lag() const { return value.size() > parts * each(); }
  std::size_t each() const { return static_cast<std::size_t>(1 + powers) + (both_orientations ? 1 : 0); }
  std::vector<double> row(const Level& level) const;  ///< regressors of one part at a level [each()]
};

/// Generalised least squares on the levels with their full covariance, so that their pattern also determines what is
/// common to the levels (gain and azimuth of the reference gyro). The order as given; with -1 the highest that has a
/// level to spare (cubic with two and three levels, quintic with four): a lower one would set its terms to zero, and
/// their uncertainty with them.
///
/// Where the quantities have a lag, `value` has one too, and its covariance with the levels determines it. Given:
/// observations [1], for AICc.
Polynomial polynomial_of(const Quantities& quantities, const std::vector<Level>& levels, Take take, int powers,
                         double observations);

}  // namespace tumble::dtg_centrifuge
