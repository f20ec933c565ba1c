#pragma once

#include <string>
#include <string_view>

#include "tumble/language/text.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

/// The word of a kind of error for programs: "bad_input".
std::string_view code_of(Error::Kind kind);

/// Problems as JSON, a list of {code, message, pattern, values, where}: `message` in this language, the others as they
/// are in every language. `where` has the members file, line, column, table, key, channel and time [s] that are known,
/// and `place`, the sentence that says them. A value that is a list of names has `names` beside its `name`.
std::string problems_to_json(std::string_view code, const Problems& problems, Language language);

/// A sentence as JSON, {pattern, values}, which stands as <member>_said beside its English text <member>. Empty: the
/// sentence is empty, or a text from elsewhere, Sentence(text), of which nothing else is known.
std::string sentence_to_json(const Sentence& said);

/// Reads it again. Throws Error::bad_file.
Sentence sentence_from_json(const std::string& text);

/// Problems that a process of ours has handed on.
struct CodedProblems {
  std::string code;  ///< kind of the error, "bad_input"; empty without problems
  Problems problems;
};

/// Reads them again. Throws Error::bad_file.
CodedProblems coded_problems_from_json(const std::string& text);

}  // namespace tumble
