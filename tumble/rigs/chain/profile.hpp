#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "tumble/core/schedule.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::chain {

/// Angle of an axis with its first two derivatives.
struct Turn {
  double angle = 0.0;         ///< [rad]
  double rate = 0.0;          ///< [rad/s]
  double acceleration = 0.0;  ///< [rad/s^2]
};

/// From 0 at s = 0 to 1 at s = 1 with two continuous derivatives [1/s, 1/s^2 where it takes `duration`]:
///
///   s^3 (10 - 15 s + 6 s^2)
Turn smooth_step(double s, double duration);

/// Limits of the drive of one axis.
struct AxisLimits {
  std::string axis;
  double max_rate = 1.0;                                     ///< [rad/s], > 0
  double max_acceleration = 1.0;                             ///< [rad/s^2], > 0
  double lowest = -std::numeric_limits<double>::infinity();  ///< [rad]
  double highest = std::numeric_limits<double>::infinity();  ///< [rad]
};

/// How the drive departs from its commands.
struct DriveErrors {
  std::vector<double> positioning = {};  ///< added to the angle held, a segment each [rad]; empty: 0
  double rate = 0.0;                     ///< relative, of commanded rates
  double amplitude = 0.0;                ///< relative, of commanded oscillations
};

/// From `begin` until the next piece: a parabola, and an oscillation about it that fades in,
///
///   angle = angle0 + rate0 s + acceleration s^2/2 + e A sin(psi),   s = t - begin
///   psi   = phase + w0 (exp(k u) - 1)/k,   u = t - origin   (k = 0: phase + w0 u)
struct Piece {
  double begin = 0.0;      ///< [s]
  Turn start = {};         ///< at begin; the acceleration lasts
  double amplitude = 0.0;  ///< A [rad]
  double origin = 0.0;     ///< [s] where psi = phase
  double phase = 0.0;      ///< [rad]
  double frequency = 0.0;  ///< w0 [rad/s]
  double growth = 0.0;     ///< k [1/s]
  double fade = 0.0;       ///< time in which e goes from 0 to 1 [s]
};

/// The motion of one axis over a run in closed form.
struct Profile {
  std::vector<Piece> pieces;             ///< in order of time; the last one lasts
  std::vector<double> rests_until = {};  ///< a piece each: when the axis leaves its angle [s]; its begin if it moves
  std::vector<double> settled;  ///< a segment each: when the axis does as commanded [s], at most the segment's end
};

/// Motion that the drive of an axis makes of a run's schedule. The axis starts at rest, at the angle that the first
/// segment holds, else at 0. It changes rate with max_acceleration:
///
/// * hold: goes there by the fastest move within the limits and stands. After a `rate` motion on an axis without stops
///   it takes the nearest of the angles that differ by whole turns.
/// * slew: the same at the given speed.
/// * rate: changes to that rate and keeps it.
/// * sine, sweep: returns to where it stood, then oscillates about this angle; the amplitude fades in over two periods.
///   The phase counts from the beginning of the segment.
/// * rate, sine with `from`: under way at that angle (about it) from the beginning. The angle of a rate was found from
///   readings, of which the middle is at half of `lasts`: there an error of the rate changes nothing. It counts as
///   settled when the same command without `from` would have: the recording may hold a change of rate that the angle
///   alone does not show.
/// * not mentioned: what was to be held stays so; what turned or oscillated comes to rest.
///
/// Problems (limits, motions not reached within their segment) are appended to `problems` unless it is null.
Profile profile_of(const Schedule& run, const AxisLimits& limits, const DriveErrors& errors, Problems* problems);

/// State at `time` [s]; `piece` is where to look first and is left where it was found.
Turn at(const Profile& profile, double time, std::size_t& piece);

/// Until when the axis stands where it stands at `time` [s]; `time` itself when it moves.
double steady_until(const Profile& profile, double time);

/// Sets rests_until from the pieces.
void find_rests(Profile& profile);

}  // namespace tumble::chain
