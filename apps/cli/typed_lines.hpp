#pragma once

#include <optional>
#include <string>

/// Lines of standard input for one who may not wait: a thread of its own reads them. That something was there to be
/// read is no promise, because another program at the same terminal may take it first (`tumble run ... | less`).
namespace tumble::cli {

/// Begins to read, once.
void begin_typed_lines();

/// The next line that has come, without its end; nothing where none has.
std::optional<std::string> next_typed_line();

}  // namespace tumble::cli
