#pragma once

#include <functional>

#include "tumble/core/recording.hpp"

namespace tumble::support {

/// What `look` says of each channel, in their order; several are looked at at the same time.
Findings findings_of_each(const Recording& recording, const std::function<Findings(const Channel&)>& look);

}  // namespace tumble::support
