#pragma once

#include <vector>

#include "tumble/methods/dtg_centrifuge/effects.hpp"
#include "tumble/methods/dtg_centrifuge/fit.hpp"

/// The lag of a capture loop that nobody stated, docs/equations (1.17): each line of the gyro at a rate w is shown
/// with the factor exp(-i w T), which turns the sensitive term against the angle more and more from level to level.
namespace tumble::dtg_centrifuge {

/// The lines of one output without a lag of so many seconds.
std::vector<Measured> without_lag(std::vector<Measured> measured, Signal output, double seconds);

/// Change of the levels by one second of lag [rad/s / (m/s^2) / s], p and q of each level.
std::vector<double> lag_column(const Circumstances& around, const std::vector<Observation>& observations,
                               std::size_t levels);

/// What the levels show of the lag, beside polynomials of p and q.
struct LagFit {
  double value = 0.0, sd = 0.0;  ///< [s]
  double degrees_of_freedom = 0.0;
};

/// Given: polynomial with the column of the lag, through these levels.
LagFit lag_of(const Quantities& levels, const Polynomial& polynomial);

}  // namespace tumble::dtg_centrifuge
