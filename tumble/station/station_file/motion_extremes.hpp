#pragma once

#include <optional>

#include "tumble/core/schedule.hpp"

namespace tumble::station_file {

/// How far a motion goes: the value of the axis (rad, K, m/s^2), its first and its second derivative by time.
struct MotionExtremes {
  std::optional<double> place;         ///< [u] where it goes or stays; absent: it begins where the axis is
  double lowest = 0.0, highest = 0.0;  ///< [u] from where the axis is, <= 0 and >= 0
  double rate = 0.0;                   ///< [u/s] greatest by magnitude, of one direction with its sign
  double acceleration = 0.0;           ///< [u/s^2] greatest magnitude
  double crest = 1.0;                  ///< [1] of a random motion: its peaks over its standard deviation
};

/// The extremes of each kind of motion, in one table that a new kind does not compile without.
///
/// The peaks of a random motion have no bound by themselves. Where the drive clips them at c standard deviations, that
/// is the peak. Else it is the level k that both signs together exceed once in a hundred segments of this duration:
/// a Gaussian process of standard deviation s crosses k s upwards at the rate nu exp(-k^2/2), where nu is that of zero
/// (S. O. Rice 1945, nu^2 = integral of f^2 S over the integral of S), so that 2 nu T exp(-k^2/2) = 1/100.
///
/// Given     motion    [u = rad, K or m/s^2]
///           seconds   for which it goes on
///           clips_at  [1] standard deviations at which the drive clips; absent: it does not
MotionExtremes extremes_of(const Motion& motion, double seconds, std::optional<double> clips_at);

}  // namespace tumble::station_file
