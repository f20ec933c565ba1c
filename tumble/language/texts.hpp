#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "tumble/language/text.hpp"

namespace tumble {

/// A text where text/<code>.toml has it: for what is written in the code in English. A section is one word or two:
/// "summary", "option.static_bias".
std::optional<std::string> find_text(Language language, std::string_view section, std::string_view key);

/// A whole section of text/<code>.toml by key, for a page that carries its own texts. Throws Error::internal for a
/// section that the file lacks.
std::map<std::string, std::string> texts_of(Language language, std::string_view section);

}  // namespace tumble
