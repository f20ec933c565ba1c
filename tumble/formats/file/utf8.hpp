#pragma once

#include <string_view>

namespace tumble::file {

/// Whether these are valid UTF-8; a character may be cut off at the end.
bool valid_utf8(std::string_view bytes);

}  // namespace tumble::file
