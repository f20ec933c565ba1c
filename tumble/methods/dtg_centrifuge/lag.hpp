#pragma once

#include <vector>

#include "tumble/methods/dtg_centrifuge/effects.hpp"
#include "tumble/methods/dtg_centrifuge/fit.hpp"

/// The lag of a capture loop that nobody stated, docs/equations (1.17): each line of the gyro at a rate w is shown
/// with the factor exp(-i w T), which turns the sensitive term more and more from level to level, and the other way
/// where arm and table turn the other way.
namespace tumble::dtg_centrifuge {

/// Standard deviation of a lag that is not known: a few milliseconds. This one is of 11 Hz with a damping ratio of 0.7.
inline constexpr double usual_lag = 0.02;  // [s] standard deviation about zero

/// The lines of one output without a lag of so many seconds [s].
std::vector<Measured> without_lag(std::vector<Measured> measured, Signal output, double seconds);

/// The lag beyond the one that the lines are corrected for, `known` [s].
LagColumn lag_column(const Circumstances& around, const std::vector<Observation>& observations, double known);

/// Lag [s] that levels and polynomial show, beyond the one that the lines are corrected for.
struct LagFit {
  double value = 0.0, sd = 0.0;
  std::vector<double> gradient;  ///< [s] by the quantities of the levels
};
LagFit lag_of(const Quantities& levels, const Polynomial& polynomial);

/// The levels as they are with the lag that the polynomial shows, not with what they show each alone: derivatives by
/// the quantities, a row a level and part [2L x n]. Identity [n x n] where there is no lag.
Matrix levels_with_lag(const Quantities& levels, const Polynomial& polynomial);

}  // namespace tumble::dtg_centrifuge
