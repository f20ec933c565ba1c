#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "tumble/core/text.hpp"

namespace tumble {

/// A text where text/<code>.toml has it: for what is written in the code in English. A section is one word or two:
/// "summary", "option.static_bias".
std::optional<std::string> find_text(Language language, std::string_view section, std::string_view key);

/// A whole section of text/<code>.toml by key; a text with a singular and a plural has "key.one" and "key.other". Throws
/// Error::internal where there is no such section.
std::map<std::string, std::string> texts_of(Language language, std::string_view section);

}  // namespace tumble
