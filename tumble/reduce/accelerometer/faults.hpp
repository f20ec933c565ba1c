#pragma once

#include "tumble/core/evidence.hpp"
#include "tumble/reduce/accelerometer/scale_factor.hpp"

/// What goes wrong in tests position by position, and what to do about it.
namespace tumble::accelerometer {

/// One position under several labels: they count as repeats. One label for several positions.
Findings about_labels(const Plan& plan);

/// Different positions, after repeats are taken together.
std::size_t different_positions(const Plan& plan);

/// Where the greatest or the least output is the same at positions that should differ, or short of what the others say
/// in more than one: the output is clipped there.
/// Where counts are off by a power of two: the counter overflowed. Throws Error::bad_data for both.
void refuse_clipped_and_overflown(const Evidence& evidence, const Normalised& found);

/// Segments whose output goes on changing between the halves of the samples used, beyond a 1e-4 of it and its noise.
Findings about_unsettled(const Evidence& evidence, const Normalised& found);

/// A single position without which the others agree with the model at least five times better, and where it would fit.
Findings about_misplaced(const linear::Solution& solution);

/// A negative scale factor, one far from that given in the settings, an input axis far from the axis of the model.
Findings about_signs(const Estimate& estimate, const Settings& settings, const Output& output);

}  // namespace tumble::accelerometer
