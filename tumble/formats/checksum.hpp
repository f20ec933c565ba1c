#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace tumble {

/// SHA-256 of these bytes, lower-case hex.
std::string sha256_of(std::string_view bytes);
/// SHA-256 of the bytes of a file, lower-case hex. Throws Error::bad_file.
std::string sha256_of_file(const std::string& path);
/// The checksum, on a thread of its own: the call of what is returned waits for it.
std::function<std::string()> sha256_in_background(const std::string& path);

}  // namespace tumble
