#pragma once

#include <string>

#include "tumble/core/finding.hpp"
#include "tumble/reduce/stretches.hpp"

namespace tumble::linear {

/// Whether stretch b follows stretch a in the recording without a pause.
bool adjoin(const ConductedTest& test, const Stretch& a, const Stretch& b);

/// Whether the segments begin and end in the recording where the schedule or the marks say.
///
/// A recording that begins late leaves samples of the next position at the end of every segment, one that begins early
/// leaves samples of the position before at the begin. An error where the outermost used samples lie on the way from
/// their own level to that of the neighbour: the median share of the way, over the segments whose neighbour differs by
/// a third of the greatest step or more, at least three, is beyond six times its noise by the scatter in the middle
/// half of each segment, and three times its scatter from segment to segment. At the begin, an output that approaches
/// its level slowly is no such step: see warn_of_lack_of_fit.
///
/// Given     test   as carried out, with the values of all used samples
///           role   of the channel, for the findings
Findings about_boundaries(const ConductedTest& test, const std::string& role);

/// Whether about_boundaries found something: other tests of what the segments show would name a wrong cause.
bool misplaced(const Findings& findings);

}  // namespace tumble::linear
