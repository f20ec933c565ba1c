#pragma once

#include <string>
#include <vector>

#include "tumble/rigs/rig.hpp"
#include "tumble/units/sentence.hpp"

/// An oven around the instrument on a machine with turning axes: the axis `temperature` of its plan.
namespace tumble::chain {

struct Imperfection;
class ErrorValues;

/// From `begin` until the next piece: the air goes along a straight line, the instrument follows with a first-order
/// lag, in closed form.
struct OvenPiece {
  double begin = 0.0;    ///< [s]
  double air = 293.15;   ///< [K] at begin
  double slope = 0.0;    ///< [K/s]
  double behind = 0.0;   ///< [K] instrument minus air at begin
  bool lagging = false;  ///< false: the instrument stands at the air's temperature, to the last digit
};

/// The oven's doing over one run.
struct Oven {
  double time_constant = 1.0;        ///< [s] of the instrument
  double offset = 0.0, scale = 0.0;  ///< of the thermometer that regulates: the air is warmer than commanded by
                                     ///< offset + scale (T - 0 degC)
  std::vector<OvenPiece> pieces;     ///< empty: not used, the laboratory's temperature
  std::vector<double> settled;       ///< a segment each: when the instrument is as warm as commanded, to 0.05 K [s]
};

/// Temperature of the instrument and its rate.
struct Warmth {
  double temperature = 293.15;  ///< [K]
  double rate = 0.0;            ///< [K/s]
};

Axis oven_axis();
std::vector<Option> oven_options();
/// The thermometer: offset and scale.
std::vector<Imperfection> oven_imperfections();
/// Options out of bounds.
void check_oven(const Settings& options, Problems& problems);
/// Temperatures that the oven cannot do, or not within their segment.
void check_oven_schedule(const Schedule& schedule, const Settings& options, Problems& problems);

/// Course of the oven under a run's schedule. It starts at the first temperature that is held, soaked through; else in
/// the laboratory.
Oven oven_of(const Schedule& run, const Settings& options, const ErrorValues& errors);

/// Warmth of the instrument at `time` [s]. `piece` is the index where the search begins, and is set to the piece found.
/// The oven has pieces.
Warmth at(const Oven& oven, double time, std::size_t& piece);

/// Temperature [K] that the thermometer shows while the instrument is at `temperature` [K].
double shown_by(const Oven& oven, double temperature);

/// Until when the temperature stays as it is [s]. Given: time [s].
double steady_until(const Oven& oven, double time);

}  // namespace tumble::chain
