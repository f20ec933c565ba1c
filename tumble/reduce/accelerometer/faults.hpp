#pragma once

#include "tumble/core/evidence.hpp"
#include "tumble/reduce/accelerometer/scale_factor.hpp"

/// Faults of tests position by position, and their remedies.
namespace tumble::accelerometer {

/// Findings about one position under several labels, which count as repeats, and about one label of several positions.
Findings about_labels(const Plan& plan);

/// Number of different positions; repeats count once.
std::size_t different_positions(const Plan& plan);

/// Throws Error::bad_data for an output that is clipped (the greatest or the least output is the same at positions that
/// should differ, or at several of them less than the others predict), and for a counter that overflowed (counts are
/// off by a power of two). Not where samples of the next position lie in every segment: see linear::misplaced.
void refuse_clipped_and_overflown(const Evidence& evidence, const Normalised& fit);

/// Adds findings about
///   segments whose output still changes between the halves of the samples used, by more than 1e-4 of it and its noise;
///   an output at its limits, see about_limits;
///   two positions whose outputs are exchanged, or one position without which the others agree with the model at least
///   five times better;
///   a negative scale factor, one far from that of the settings, an input axis far from the axis of the model, and
///   coefficients that no accelerometer has.
void add_faults(const Evidence& evidence, const Normalised& fit, Estimate& estimate);

}  // namespace tumble::accelerometer
