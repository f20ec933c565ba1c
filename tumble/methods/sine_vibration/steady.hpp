#pragma once

#include "tumble/reduce/vibration/vibration.hpp"

namespace tumble::sine_vibration {

/// Cuts the tones to the time in which the shaker runs, and says which of them are not steady along their segment: the shaker
/// still runs up, the gain of the unit changes, or its mean does.
///
/// A tone is looked at in 20 blocks, each with a sine and a mean at the planned frequency.
void check_steadiness(vibration::Data& data);

}  // namespace tumble::sine_vibration
