#pragma once

#include <string>
#include <string_view>

namespace tumble {

/// Bytes in the 64 characters of RFC 4648, on one line.
std::string base64_of(std::string_view bytes);

}  // namespace tumble
