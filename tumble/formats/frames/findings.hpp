#pragma once

#include <string>

#include "tumble/core/finding.hpp"
#include "tumble/formats/frames/choose.hpp"

namespace tumble::frames {

/// Findings of a reader about a stream: which declaration, frames that are damaged, missing, repeated or skipped,
/// statuses that are not good.
Findings findings_of(const Chosen& chosen, const FrameCounts& counts, const std::string& path);

}  // namespace tumble::frames
