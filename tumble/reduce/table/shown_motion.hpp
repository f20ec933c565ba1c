#pragma once

#include <complex>
#include <optional>
#include <vector>

#include "tumble/core/schedule.hpp"

/// The motion of an axis that readings of its angle show.
namespace tumble::table {

/// Angles [rad] at times [s] since the beginning of a segment.
struct Angles {
  std::vector<double> times, values;
};

/// Where a motion is, by angles.
struct Phase {
  double from = 0.0;               ///< [rad]
  double known_at = 0.0;           ///< rate: mean time of the readings [s since the beginning of the segment]
  std::complex<double> wave = {};  ///< sine: amplitude exp(j phase) by that of the plan; 1 if it is as planned
};

/// rate   from = arg sum_i exp(j (th_i - W t_i)); nothing where the residuals are above 26 deg
/// sine   th = from + A sin(phase + 2 pi f t) at the frequency of the motion; nothing with less than a period
std::optional<Phase> phase_of(const Motion& motion, const Angles& angles);

/// By how much an axis turns at another rate than commanded [rad/s].
struct RateDeparture {
  double rate = 0.0;
  double sd = 0.0;      ///< by the scatter of the readings about the line, and their greatest step
  bool steady = false;  ///< the same in both halves of the time, within the tolerance and their scatter
};
/// The slope of angle - W t; nothing where the readings are too few. Readings that are further apart than half a turn of
/// the departure show another one. Given: tolerance [rad/s] between the halves.
std::optional<RateDeparture> departure_of_rate(double rate, const Angles& angles, double tolerance);

/// An oscillation, compared with that of the plan.
struct ShownOscillation {
  double frequency = 0.0, frequency_sd = 0.0;  ///< [Hz]
  double amplitude = 0.0, amplitude_sd = 0.0;  ///< [1] of that of the plan
};
/// Least squares of four parameters; nothing where the readings hold less than a period or no oscillation.
std::optional<ShownOscillation> oscillation_of(const Motion& motion, const Angles& angles);

/// Readings [rad] without the jumps of a turn.
std::vector<double> unwrapped(std::vector<double> values);

}  // namespace tumble::table
