#pragma once

#include <cstdint>
#include <string>

#include "tumble/formats/file/temporary_file.hpp"
#include "tumble/formats/format.hpp"

namespace tumble::file {

/// Refuses what unpacks to much more than data do. Given: bytes unpacked so far and bytes packed; `from` for the
/// message. Throws Error::bad_file.
void check_unpacked_size(std::uintmax_t unpacked, std::uintmax_t packed, const std::string& from);

/// A recording that was packed in another file: read from the unpacked copy, and said to be in `outer`.
struct PackedFile {
  const TemporaryFile& copy;
  std::string outer;  ///< file as the user wrote it
  std::string name;   ///< of the recording in it
};

/// The format of the copy. Throws Error::bad_file, also for a packed file in a packed file.
const Format& format_of(const PackedFile& packed, const ReadOptions& options = {});

/// As the functions of Format. Origin and checksum are those of `outer`.
Recording read(const PackedFile& packed, const ReadOptions& options, const Progress& progress);
std::uintmax_t memory(const PackedFile& packed, const ReadOptions& options);
void stream(const PackedFile& packed, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress);

}  // namespace tumble::file
