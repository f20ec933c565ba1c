#pragma once

#include <vector>

#include "tumble/methods/rlg_north_finder/closed_form.hpp"
#include "tumble/methods/rlg_north_finder/outputs.hpp"

/// Faults of such a test, by name.
namespace tumble::rlg_north_finder {

inline constexpr const char* axis_names[] = {"x", "y", "z"};

/// Positions in another order, turns the other way, accelerometers exchanged or reversed: the accelerometers against
/// the plan, stay by stay; the Earth's rate in the gyro distinguishes these cases.
Findings order_faults(const Summaries& segments);

/// Rotations: the number of turns and their sense by what the gyro shows of the Earth's rate at rest, forward against
/// reverse, unequal times, rates near multiples of dither frequency over scale factor.
///
/// Given  estimate  with parameters in the order of wanted()
///        recorded  whether the segments hold the angles that encoders recorded
Findings rotation_faults(const Plan& plan, const Summaries& segments, const Estimate& estimate, bool recorded);

/// Rotations about another axis than the plan says, in the other sense, of another number of turns: by how gravity goes
/// round in the accelerometers on the way, or the Earth's rate in the gyro where the axis is upright.
///
/// Given  evidence  with the channels in pulses per second
Findings turn_faults(const Evidence& evidence, const Summaries& segments);

/// Counts within the stays: lock-in, dither that is cut off, a table that has not come to rest.
Findings count_faults(const Evidence& evidence, const Summaries& segments, const Estimate& estimate);

}  // namespace tumble::rlg_north_finder
