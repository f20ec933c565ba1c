#pragma once

#include <cstddef>

#include "tumble/core/recording.hpp"

namespace tumble {

/// When the segment that a mark begins ends.
///
/// Given     mark   index in Recording::marks
/// Returned  the beginning of the next mark [s, recording's clock]; infinity for the last one, which ends with the data
double end_of_mark(const Recording& recording, std::size_t mark);

}  // namespace tumble
