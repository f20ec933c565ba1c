#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace tumble::storage {

/// A text, compressed; and back. unpacked() throws Error::bad_file for damaged bytes, which `what` names.
std::string packed(std::string_view text);
std::string unpacked(std::string_view bytes, const std::string& what);

/// Where a folder keeps the file of this SHA-256: two letters of it are a folder, so that none becomes large.
std::string place_of(const std::string& folder, const std::string& sha256);

/// Keeps a file under the name of its SHA-256, compressed: whole and synchronised, or not at all. One that is there
/// stays. Behind the compressed bytes stands their own SHA-256, in a frame that Zstandard skips: `zstd -d` unpacks it.
/// Returns the SHA-256 of the file. Throws Error::bad_file.
std::string keep(const std::string& folder, const std::string& path);
/// As keep(), for bytes in memory.
std::string keep_bytes(const std::string& folder, std::string_view bytes);

/// Hands out the bytes of a file that is kept, piece by piece. Throws Error::bad_file: it is missing, its bytes have
/// changed, or they are not those of this SHA-256.
void unpack(const std::string& folder, const std::string& sha256, const std::function<void(std::string_view)>& sink);
/// Writes it to a file. Throws as unpack().
void unpack_to(const std::string& folder, const std::string& sha256, const std::string& path);

}  // namespace tumble::storage
