#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tumble/formats/file/inflate.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::zip {

/// A file in an archive, as the central directory has it.
struct Entry {
  std::string name;  ///< with its folders
  std::uint16_t method = 0;
  bool encrypted = false;
  std::uint32_t checksum = 0;
  std::uint64_t packed = 0, size = 0;  ///< [bytes]
  std::uint64_t header = 0;            ///< [bytes] where its local header begins
};

/// Whether a file begins as an archive does.
bool is_archive(const std::string& path);

/// The files of an archive, without folders and what systems add to it. Throws Error::bad_file.
std::vector<Entry> entries_of(const std::string& path);

/// Unpacks one of them (stored or deflated), and compares size and checksum. Throws Error::bad_file.
void unpack(const std::string& path, const Entry& entry, const file::ByteSink& sink);

/// Names for a message, the first ten.
Sentence listed(const std::vector<Entry>& entries);

}  // namespace tumble::zip
