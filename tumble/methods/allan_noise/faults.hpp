#pragma once

#include <span>
#include <string>

#include "tumble/core/finding.hpp"
#include "tumble/methods/allan_noise/describe.hpp"

namespace tumble::allan_noise {

/// A finding where the least step of the output is so much larger than its noise that the noise cannot be read off it:
/// from 2.3 standard deviations of a sample on, where the rounding error is no longer independent of the noise.
///
/// Given     values  [u]; NaN: missing
/// Returned  no or one finding
Findings coarse_output(std::span<const double> values, const std::string& label);

/// Findings for processes whose correlation time lies at an end of the range that is searched.
Findings times_at_bound(const ChannelNoise& channel);

/// A finding where a Gauss-Markov process is nearly all of the noise: white noise that a sensor filters by a low pass
/// of first order looks the same, and its density at frequency zero is then the process', not that of the white noise
/// beside it.
Findings process_like_filter(const ChannelNoise& channel);

/// A finding where the noise falls as behind a filter so near to the slower terms that flicker and the edge of the filter, whose
/// shape nobody has stated, are one for the fit.
Findings filter_near_slow_terms(const ChannelNoise& channel);

}  // namespace tumble::allan_noise
