#pragma once

#include <vector>

#include "tumble/methods/dtg_centrifuge/effects.hpp"
#include "tumble/methods/dtg_centrifuge/fit.hpp"

/// The lag of a capture loop that nobody stated, docs/equations (1.17): each line of the gyro at a rate w is shown
/// with the factor exp(-i w T), which turns the sensitive term more and more from level to level, and the other way
/// where arm and table turn the other way.
namespace tumble::dtg_centrifuge {

/// The lines of one output without what a low pass does to them.
std::vector<Measured> without_filter(std::vector<Measured> measured, Signal output, const Filter& filter);

/// Standard deviation of a lag that is not known: a few milliseconds. This one is of 11 Hz with a damping ratio of 0.7.
inline constexpr double usual_lag = 0.02;  // [s] standard deviation about zero

/// The lines of one output without a lag of so many seconds [s].
std::vector<Measured> without_lag(std::vector<Measured> measured, Signal output, double seconds);

/// The lag beyond the one that the lines are corrected for, `corrected` [s]: what is known beforehand, 0 +- usual_lag, and
/// what the harmonics say.
LagColumn lag_column(const Circumstances& around, const std::vector<Observation>& observations, double corrected,
                     const std::vector<Quantities>& harmonics);

/// A harmonic with the lag as a quantity of its own, about which the harmonic alone decides: it turns by h w T. Without the
/// lag where the harmonic is less than `significant_harmonic` standard deviations.
Quantities harmonic_with_lag(const Circumstances& around, const std::vector<Observation>& observations,
                             const std::vector<Effect>& effects, int harmonic);
inline constexpr double significant_harmonic = 5.0;  // [sd] p = 4e-6 for two parts

/// Lag [s] that levels and polynomial show, beyond the one that the lines are corrected for.
struct LagFit {
  double value = 0.0, sd = 0.0;
  std::vector<double> gradient;  ///< [s] by the quantities of the levels
};
LagFit lag_of(const Quantities& levels, const Polynomial& polynomial);

/// One part of a harmonic as it is with the lag that the whole test shows, and its derivatives by the quantities of the
/// harmonic and of the levels.
struct HarmonicPart {
  double value = 0.0;
  std::vector<double> by_harmonic, by_levels;
};
HarmonicPart harmonic_part(const Quantities& harmonic, std::size_t part, const Quantities& levels,
                           const Polynomial& polynomial);

/// The levels as they are with the lag that the polynomial shows, not with what they show each alone: derivatives by
/// the quantities, a row a level and part [2L x n]. Identity [n x n] where there is no lag.
Matrix levels_with_lag(const Quantities& levels, const Polynomial& polynomial);

}  // namespace tumble::dtg_centrifuge
