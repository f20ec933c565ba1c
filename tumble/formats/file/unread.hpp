#pragma once

#include <string>

#include "tumble/units/sentence.hpp"

namespace tumble::file {

/// For a file of a well-known kind that is not read: what it is, and how its samples can be brought here, to follow
/// "'file' is ". Empty for any other file. Throws Error::bad_file.
Sentence advice_for_unread(const std::string& path);

/// The rest of the sentence "FILE is ..." for a file that is no recording: a plan, or a result; else empty.
Sentence advice_for_other_kind(const std::string& path);

}  // namespace tumble::file
