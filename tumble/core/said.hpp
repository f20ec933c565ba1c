#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/text.hpp"

namespace tumble {

/// A sentence that the program says in English, a message of an error, a note, what is being done, for people who read
/// this language. Its pattern with the places of its values, "there is no list of '{}'", is the key in [said] of
/// text/<code>.toml, so that every place that throws writes plain English. A value that is a sentence itself is
/// translated, too, and so is what follows "file:12: ". A sentence that the table lacks stays English.
/// A text of several lines is translated line by line.
std::string said_in(Language language, std::string_view english);

/// Each of them.
std::vector<std::string> said_in(Language language, std::vector<std::string> english);

/// A name or a sentence of a result: a description of a parameter, a source of a budget, a caption, a column, an axis
/// of a figure. The patterns are in [result] of text/<code>.toml, and a value is looked up there even if it is one
/// word, "gain over {}". Absent: the table lacks it, or the language is English.
std::optional<std::string> result_words_in(Language language, std::string_view english);

}  // namespace tumble
