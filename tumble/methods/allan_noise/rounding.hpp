#pragma once

#include <span>

#include "tumble/methods/allan_noise/describe.hpp"

namespace tumble::allan_noise {

/// Takes the rounding of each sample to steps q out of the white noise of a fit, and says so. Where the noise is half a step
/// and more, rounding is white noise of its own, of variance q^2/12: the record's white noise is the sum of both. Nothing is
/// taken out where no step is seen, where a filter shapes the white noise, or where the rest of the rounding may be passed on to the
/// next sample, as counters do: that is quantization.
///
/// Given     values  samples of the record [u], NaN: missing
/// See       Widrow and Kollar, Quantization Noise (2008), chapter 5
void take_rounding_out(std::span<const double> values, ChannelNoise& result);

}  // namespace tumble::allan_noise
