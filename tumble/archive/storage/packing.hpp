#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "tumble/archive/database/database.hpp"

namespace tumble::storage {

/// A text, compressed, with a seal at its end: the SHA-256 of the compressed bytes, in a frame that Zstandard skips. So
/// a flipped bit is found also where it would not change the text.
std::string packed(std::string_view text);
/// And back. Throws Error::bad_file for damaged bytes, which `what` names. Bytes without a seal are those of an archive
/// of version 1.
std::string unpacked(std::string_view bytes, const Sentence& what);
/// The SHA-256 of these bytes, where they have a seal; else empty.
std::string seal_of(std::string_view bytes);

/// Where files are kept: in a folder, or where it is empty in the table `contents` of the database.
struct Place {
  std::string folder;
  database::Database* database = nullptr;
};

/// Where a folder keeps the file of this SHA-256: two letters of it are a folder, so that none becomes large.
std::string place_of(const std::string& folder, const std::string& sha256);

/// Keeps a file under the name of its SHA-256, packed: whole and synchronised, or not at all. One that is there stays.
/// `zstd -d` unpacks it. Returns the SHA-256 of the file. Throws Error::bad_file, database::Refusal.
std::string keep(const Place& place, const std::string& path);
/// Whether there is a file of this SHA-256; it may be damaged.
bool is_kept(const Place& place, const std::string& sha256);

/// Hands out the bytes of a file that is kept, piece by piece. Throws Error::bad_file: it is missing, its bytes have
/// changed, or they are not those of this SHA-256.
void unpack(const Place& place, const std::string& sha256, const std::function<void(std::string_view)>& sink);
/// Writes it to a file. Throws as unpack().
void unpack_to(const Place& place, const std::string& sha256, const std::string& path);

}  // namespace tumble::storage
