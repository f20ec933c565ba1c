#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/language/text.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble {

/// A sentence for people who read this language, from its pattern and its values: the pattern is the key in [said] of
/// text/<code>.toml. Names, numbers and texts stay as they are; a sentence in it is translated. What cannot be
/// translated whole is English whole. What stands before ": " in a pattern may be translated apart from what follows.
std::string in_language(Language language, const Sentence& said);
/// The sentence of a problem with its place before it.
std::string in_language(Language language, const Problem& problem);
/// Each of them.
std::vector<std::string> in_language(Language language, const Problems& problems);

/// A sentence of a library (of its command line, of its files): pattern and values are found by the keys of
/// [said_by_libraries], and its values are names. Where none fits, the text itself, which has no translation.
Sentence said_by_library(const std::string& text);

/// A stored text of a run, of a plan, of a list: what was written in English. A sentence that the program says, a
/// message of an error, a note, what is being done, for people who read this language. Its pattern with the places of
/// its values, "there is no list of '{}'", is the key in [said] of text/<code>.toml, so that every place that throws
/// writes plain English. A value that is a sentence itself is translated, too, and so is what follows "file:12: ". A
/// sentence that the table lacks stays English. A text of several lines is translated line by line.
std::string said_in(Language language, std::string_view english);

/// Each of them.
std::vector<std::string> said_in(Language language, std::vector<std::string> english);

/// A name or a sentence of a result: a description of a parameter, a source of a budget, a caption, a column, an axis
/// of a figure. The patterns are in [result] of text/<code>.toml, and a value is looked up there even if it is one
/// word, "gain over {}". Absent: the table lacks it, or the language is English.
std::optional<std::string> result_words_in(Language language, std::string_view english);

}  // namespace tumble
