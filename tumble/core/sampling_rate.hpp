#pragma once

#include "tumble/core/channel.hpp"

namespace tumble {

/// Rate [Hz] of the clock behind a channel: as declared, or for stamps as clock_of() finds it, so that lost samples do
/// not change it; the mean rate where the stamps show no clock.
double sampling_rate(const Channel& channel);

}  // namespace tumble
