#pragma once

#include <vector>

#include "tumble/methods/dtg_centrifuge/describe.hpp"

/// Why the levels do not lie on their polynomial: causes whose pattern over the levels is known.
namespace tumble::dtg_centrifuge {

/// Two numbers with a known pattern over the levels, fitted in addition.
struct Cause {
  double fall = 0.0;         ///< of chi-square
  double probability = 1.0;  ///< of such a fall in a sound test [1]
  Complex value;             ///< both numbers as one
};

/// Gain [1] and azimuth [rad] of the reference gyro that the levels want beyond those by which the lines are reduced: real part
/// and imaginary part.
Cause other_relation(const Outcome& outcome, const std::vector<Measured>& measured, const std::vector<Level>& levels);

/// A line at the table's angle of the same size [rad/s] at every level: a field that turns with the arm.
Cause line_beside_force(const Outcome& outcome, const std::vector<Measured>& measured,
                        const std::vector<Level>& levels);

/// [1] the probability below which a cause is named. Chosen far below one sound test in a hundred: the covariance of few short levels
/// is itself an estimate, and two of six such tests were below 1e-3.
inline constexpr double rare_cause = 1e-6;

/// The finding of the cause that explains more, if one of the two does.
void name_cause(const Outcome& outcome, const std::vector<Measured>& measured, const std::vector<Level>& levels,
                Findings& findings);

}  // namespace tumble::dtg_centrifuge
