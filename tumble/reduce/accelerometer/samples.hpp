#pragma once

#include <string>
#include <vector>

#include "tumble/reduce/accelerometer/scale_factor.hpp"
#include "tumble/units/sentence.hpp"

/// Faults that show in single samples of a segment.
namespace tumble::accelerometer {

/// Problems: counts that are off by a power of two, and the remedy; empty: no problem.
Problems overflows_of(const Evidence& evidence, const Normalised& fit);

/// A finding about segments whose output still changes between the halves of the samples used.
Findings about_unsettled(const Evidence& evidence, const Normalised& fit);

/// An error finding about an output at its limits, of an analog output: segments of one and the same value where all
/// others scatter; or a greatest and a least output that are equal and opposite although level positions show an
/// offset.
Findings about_limits(const Evidence& evidence, const Normalised& fit);

/// The labels as a list of names, at most so many of them: "'a', 'b', 'c', 'd', 'e', 'f', ... (9)"
std::string quoted(const std::vector<std::string>& labels, std::size_t most = 6);
/// All labels, for a finding, whose values hold all that it speaks of.
inline std::string all_quoted(const std::vector<std::string>& labels) { return quoted(labels, labels.size()); }

}  // namespace tumble::accelerometer
