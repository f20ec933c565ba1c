#pragma once

#include "tumble/core/evidence.hpp"
#include "tumble/core/finding.hpp"

namespace tumble::gyro_scale_factor {

/// The recordings ready for the fit. Segments clipped at the end of the range and jumps of an overflowing counter
/// become missing samples, each with a finding; increments (counts, angles) become values per second, by the rate of
/// their own recording.
///
/// Clipped: the greatest (or least) value of the whole channel makes up a fifth or more of two segments at different
/// commanded rates, or of one where the samples of most segments differ from one another. Segments that the schedule
/// lacks are not judged. A jump: a sample farther from all segments' medians than three times their span.
Evidence screened(const Evidence& evidence, const std::string& role, Findings& findings);

/// Output [SI/s or SI] for one SI unit of the channel: the sampling rate [Hz] where the samples are increments, else 1.
double per_second_of(const Channel& channel);

/// Rate that the plan commands for an axis in a segment [rad/s]; 0 where it stands.
double commanded_rate(const Segment& segment);

}  // namespace tumble::gyro_scale_factor
