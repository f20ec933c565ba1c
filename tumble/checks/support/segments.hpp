#pragma once

#include "tumble/core/recording.hpp"

namespace tumble::support {

/// Whether nothing from `begin` to `end` [s, recording's clock] lies in a segment, in a recording whose marks say where
/// segments end: what happens on the way from one to the next is used by nobody.
bool is_between_segments(const Recording& recording, double begin, double end);

}  // namespace tumble::support
