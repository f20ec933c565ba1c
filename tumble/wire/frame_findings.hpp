#pragma once

#include <string>

#include "tumble/core/finding.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble {

/// Findings about a stream, with counts: frames that are damaged, missing, repeated or skipped, and statuses that are
/// not good. `where`: its file or link.
Findings findings_of_stream(const FrameCodec& codec, const FrameCounts& counts, const std::string& where);

}  // namespace tumble
