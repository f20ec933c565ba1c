#pragma once

#include "tumble/methods/rlg_lock_in/sweep.hpp"

namespace tumble::rlg_lock_in {

/// Whether the counts of a segment with dither are zero or multiples of two and more, but never one, though those of the
/// other segments are not: small counts are lost. What check `zeros` cannot say of a recording by itself, since a counter that
/// counts in steps gives the same there.
///
/// Given     edges  counts a fringe
Findings small_counts_lost(const Sweep& sweep, int edges);

}  // namespace tumble::rlg_lock_in
