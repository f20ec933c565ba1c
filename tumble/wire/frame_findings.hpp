#pragma once

#include <string>

#include "tumble/core/finding.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble {

/// What is damaged, missing, repeated, skipped or not good in a stream, with counts. `where`: its file or link.
Findings findings_of_stream(const FrameCodec& codec, const FrameCounts& counts, const std::string& where);

}  // namespace tumble
