#pragma once

#include <string>

namespace tumble::cli {

/// A new password: asked for twice at the terminal, without showing it; one line where standard input is no terminal.
/// Throws Error::bad_input where both differ, or nothing comes.
std::string new_password(const std::string& user);

}  // namespace tumble::cli
