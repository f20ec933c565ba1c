#pragma once

#include <span>
#include <vector>

#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/methods/allan_noise/lines.hpp"

namespace tumble::allan_noise {

/// Fits exponentials that die away from the begin of the record beside its noise, where they explain it better than
/// noise alone, and the noise of the rest. A record whose bias jumps is left as it is.
///
/// Given     begin [s] of the record
///           bands, avoided   of the record, and lines whose frequencies the fit does not use; both may change
///           result           with the fit of these bands; receives the fit of the rest, warm_up and a finding
void take_warm_up(NoiseBands& bands, const std::vector<SpectralLine>& avoided, double begin,
                  const NoiseLikelihoodOptions& options, ChannelNoise& result);

/// Adds the Allan variance of a course that was subtracted to each point of the curve.
/// Given: course [u], a value for each `unit` samples.
void add_course_variance(std::span<const double> course, double unit, ChannelNoise& result);

/// Table `settling` of the channels that settle.
void describe_warm_up(const std::vector<ChannelNoise>& channels, Estimate& estimate);

}  // namespace tumble::allan_noise
