#pragma once

#include "tumble/core/evidence.hpp"
#include "tumble/core/finding.hpp"

namespace tumble::gyro_scale_factor {

/// The recordings without what the electronics spoilt: segments clipped at the end of the range and jumps of an
/// overflowing counter become missing samples, each with a finding.
///
/// Clipped: the greatest (or least) value of the whole channel makes up a fifth or more of two segments at different
/// commanded rates, or of one where the samples of most segments differ from one another. A jump: a sample farther from
/// all segments' medians than three times their span.
Evidence screened(const Evidence& evidence, const std::string& role, Findings& findings);

/// Rate that the plan commands for an axis in a segment [rad/s]; 0 where it stands.
double commanded_rate(const Segment& segment);

}  // namespace tumble::gyro_scale_factor
