#pragma once

#include <string>

#include "tumble/core/finding.hpp"
#include "tumble/formats/frames/choose.hpp"

namespace tumble::frames {

/// What a reader says of a stream: which declaration, what is damaged, missing, repeated, skipped, not good.
Findings findings_of(const Chosen& chosen, const FrameCounts& counts, const std::string& path);

}  // namespace tumble::frames
