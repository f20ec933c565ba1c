#pragma once

#include <string>

#include "tumble/core/finding.hpp"
#include "tumble/language/text.hpp"

namespace tumble {

/// The message of a finding for people who read this language. English: `message` itself. Other languages: the sentence
/// of its code in text/<code>.toml with its values; where that has no such sentence (a method of your own, a result of
/// another version) the English message.
std::string message_in(Language language, const Finding& finding);

/// "where: message", or the message alone.
std::string placed_message_in(Language language, const Finding& finding);

/// The word of a severity on the terminal: "warning".
std::string severity_in(Language language, Finding::Severity severity);

}  // namespace tumble
