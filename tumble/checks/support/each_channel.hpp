#pragma once

#include <functional>

#include "tumble/core/recording.hpp"

namespace tumble::support {

/// Findings of `look` about each channel, in their order; several channels are looked at at the same time.
Findings findings_of_each(const Recording& recording, const std::function<Findings(const Channel&)>& look);

}  // namespace tumble::support
