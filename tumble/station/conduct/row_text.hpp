#pragma once

#include <string>

#include "tumble/station/executive.hpp"

namespace tumble::conduct {

/// A row of the journal as one JSON value, and back. Throws Error::bad_file for a text that is no row.
std::string text_of(const RunRow& row);
RunRow row_of(const std::string& text);

}  // namespace tumble::conduct
