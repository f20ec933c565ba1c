#pragma once

#include <string>
#include <vector>

#include "tumble/units/sentence.hpp"

namespace tumble {

/// Text that is kept of a password: "scrypt:32768:8:3:SALT:KEY", salt and key in hex. Made by scrypt (RFC 7914) of
/// OpenSSL with a random salt: 32 MB and a tenth of a second a guess.
std::string hash_of_password(const std::string& password);

/// Whether `hash` is of this password; compared in constant time. False for a text that is not a hash.
bool is_password(const std::string& password, const std::string& hash);

/// Whether a text is one that hash_of_password() makes.
bool is_password_hash(const std::string& hash);

/// Problems of a new password; empty: none.
Problems problems_of_password(const std::string& password, const std::string& user);

/// 256 bits that nobody can guess, in hex.
std::string random_secret();

/// Compares in a time that does not depend on where texts differ.
bool equal_in_constant_time(const std::string& a, const std::string& b);

}  // namespace tumble
