#pragma once

#include <string>

namespace tumble {

/// A value of nlohmann::json or nlohmann::ordered_json as text. A byte that is not UTF-8 becomes U+FFFD; `dump()` alone
/// throws there. indent: blanks of a level; -1: all in one line. ascii: other characters are written as \uXXXX.
template <class Json>
std::string json_text(const Json& json, int indent = -1, bool ascii = false) {
  return json.dump(indent, ' ', ascii, Json::error_handler_t::replace);
}

}  // namespace tumble
