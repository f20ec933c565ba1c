#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tumble {

/// The text with every byte that is not UTF-8 as U+FFFD and every control character (line break, escape) as a blank:
/// names come from other people's files and go to terminals and pages.
std::string printable(std::string_view text);

/// A text of several lines for a terminal: line breaks and tabs stay, and U+FFFD is written for every other control character.
std::string printable_lines(std::string_view text);

/// Columns a terminal gives to printable text: 0 for combining marks, 2 for East Asian wide characters, else 1.
std::size_t display_width(std::string_view text);

/// Printable text that takes at most so many columns of a terminal: what is longer has "…" in place of its middle.
std::string without_middle(std::string_view text, std::size_t columns);

/// A word in parts between which a line may break: beside East Asian wide characters, but not before closing
/// punctuation and not behind opening punctuation (GB/T 15834). A word without such characters is one part.
std::vector<std::string> breakable_parts(std::string_view word);

}  // namespace tumble
