#pragma once

#include <map>
#include <string>
#include <string_view>

#include "tumble/core/text.hpp"

namespace tumble {

/// A whole section of text/<code>.toml by key, for a page that carries its own texts. Throws Error::internal where
/// there is none.
std::map<std::string, std::string> texts_of(Language language, std::string_view section);

}  // namespace tumble
