#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace tumble {

/// Languages of what users read. Files and JSON are the same in all of them.
enum class Language { english, chinese };

/// Codes of all languages (ISO 639-1): "en", "zh".
const std::vector<std::string>& language_codes();
/// "en" or "zh".
std::string code_of(Language language);

/// Text for users, by section and key, from text/en.toml. A key with `one` and `other` has two texts, for a count of 1
/// and for every other count.
/// Throws Error::internal for a key that the table lacks.
std::string text_of(std::string_view section, std::string_view key, std::size_t count = 1);

/// Text for users of a language, from text/<code>.toml. Throws Error::internal for a key that the table lacks. A
/// language that needs no plural has one text where English has two.
std::string text_of(Language language, std::string_view section, std::string_view key, std::size_t count = 1);

}  // namespace tumble
