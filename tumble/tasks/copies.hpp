#pragma once

#include <vector>

#include "tumble/core/recording.hpp"

namespace tumble {

/// Natural logarithm of the chance [1] that a second recording of the same holds the same samples: the sum over the
/// channels, and over the intervals of stamps, of
///
///   sum_i ln P(two draws of what follows the values before sample i are equal)
///
/// where P is counted in the recording itself: after the two values before where they occur eight times or more, else
/// after one, else over all. A quiet output of counts that repeats one value has 0, noise of floating-point numbers
/// -ln(samples) for each of them.
double log_chance_of_equal(const Recording& recording);

/// Recordings of one content. Throws Error::bad_data where chance does not explain it (less than once in a million):
/// each would count twice and make every uncertainty too small. Two files of quiet counts may well be equal: these get
/// a finding.
void look_at_copies(std::vector<Recording>& recordings);

}  // namespace tumble
