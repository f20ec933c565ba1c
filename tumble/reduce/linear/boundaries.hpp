#pragma once

#include <string>

#include "tumble/core/finding.hpp"
#include "tumble/reduce/stretches.hpp"

namespace tumble::linear {

/// Whether the segments begin and end in the recording where the schedule or the marks say.
///
/// A recording that begins late leaves samples of the next position at the end of every segment, one that begins early
/// leaves samples of the position before at the begin. An error where the outermost used samples of two thirds of the
/// segments or more lie six times the scatter of their own segment away from its level, towards that of the
/// neighbour; a pair of segments counts where the levels differ by 20 times the scatter, and at least three must. At
/// the begin, an output that approaches its level slowly is no such step. Else a warning where the segments change
/// from their first to their last third in proportion to the step that led to them (F test, one sound test in 1e5).
///
/// Given     test   as carried out, with the values of all used samples
///           role   of the channel, for the findings
Findings about_boundaries(const ConductedTest& test, const std::string& role);

}  // namespace tumble::linear
