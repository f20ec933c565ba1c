#pragma once

#include "tumble/core/channel.hpp"

namespace tumble {

/// Rate [Hz] of the clock behind a channel: as declared, or for stamps as clock_of() finds it, so that lost samples do
/// not change it; the mean rate where the stamps show no clock.
double sampling_rate(const Channel& channel);

/// Whether sample i of both channels was taken at one time, for every i.
bool sampled_together(const Channel& a, const Channel& b);

}  // namespace tumble
