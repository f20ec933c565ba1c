#pragma once

#include <string>

namespace tumble::link {

/// Sets up an open serial device as raw bytes: rate [baud], 0 leaves it, and framing "8N1", empty leaves it. Any rate
/// that the driver can do is accepted. Returns the system's reason; empty: it is set.
std::string set_line(int descriptor, long baud, const std::string& framing);

/// The device is ours alone from now on. Returns the system's reason; empty: it is.
std::string take_alone(int descriptor);

}  // namespace tumble::link
