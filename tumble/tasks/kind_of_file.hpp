#pragma once

#include <string>

namespace tumble {

/// Kind of a file, as far as its first bytes and its name show it.
enum class FileKind { plan, result, recording, unknown };

/// Given  path  of a file; a name that is no file is unknown
FileKind kind_of_file(const std::string& path);

/// Throws Error::bad_input where a file of another kind was given for a plan or a result: what it is, and what to type.
void refuse_other_kind(const std::string& path, FileKind wanted);

}  // namespace tumble
