#pragma once

#include <string>

namespace tumble::cli {

/// [s] of a clock of the wall that never jumps.
double wall_time();

/// What --speed says: seconds of a virtual rig in each second of the wall. Throws Error::bad_input.
double speed_of(const std::string& text);

}  // namespace tumble::cli
