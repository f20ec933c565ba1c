#pragma once

#include <vector>

#include "tumble/reduce/coarse_output.hpp"
#include "tumble/reduce/linear/work.hpp"

namespace tumble::linear {

/// Covariance [steps^2] of the errors x - round(x) of numbers x_g [steps] that are known with the covariance P [steps^2]: of the
/// sawtooth
///
///   e(x) = sum_k c_k sin(2 pi k x),   c_k = -(-1)^k exp(-2 pi^2 k^2 s^2)/(pi k)
///
/// over x ~ N(places, P). Numbers that are equal, opposite or multiples of one another have errors that go together, unless
/// they are uncertain by a step.
///
/// Given     noise  s [steps] of the samples whose mean is rounded so
Matrix rounding_covariance(const std::vector<double>& places, const Matrix& uncertainty, double noise);

/// For each segment whether its output stays within a part of a step [SI], so that rounding moves all of its averages alike:
/// at rest, or at a rate that its input does not change with.
std::vector<bool> rounded_alike(const Work& work, double step);

/// Rounding to steps moves the means: those of segments whose outputs are known to a part of a step together, as the
/// coefficients of the first look place them, and alike those of all that show one and the same value throughout.
std::vector<KnownEffect> rounding_effects(const Work& work, const CoarseOutput& coarse);

}  // namespace tumble::linear
