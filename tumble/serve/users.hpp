#pragma once

#include <set>
#include <string>
#include <vector>

#include "tumble/serve/rights.hpp"

namespace tumble {

/// A person who may use a workbench.
struct User {
  std::string name;  ///< as it signs, too
  std::set<Right> roles;
  std::string password;  ///< hash_of_password()
};

/// The users of a file (docs/workbench.md). Throws Error::bad_input with all that is wrong, each with its line;
/// Error::bad_file, also where others may write the file.
std::vector<User> read_users(const std::string& path);

/// Appends a user to a file; makes a missing file, readable by its owner alone. The contents of a file stay.
/// Throws Error::bad_input where the user is there, or what read_users() refuses.
void add_user(const std::string& path, const User& user);

/// Replaces the password of a user, and nothing else of the file. Throws Error::bad_input where there is no such user.
void change_password(const std::string& path, const std::string& name, const std::string& hash);

}  // namespace tumble
