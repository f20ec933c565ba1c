#pragma once

#include <cstddef>

#include "tumble/core/recording.hpp"

namespace tumble {

/// When the segment that a mark begins ends.
///
/// Given     mark   index in Recording::marks
/// Returned  [s, recording's clock] the beginning of the next mark, or sooner, as the schedule says; infinity for a
/// last
///           one of which no schedule says how long it is: it ends with the data
double end_of_mark(const Recording& recording, std::size_t mark);

}  // namespace tumble
