#pragma once

#include <cstdint>
#include <memory>
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
  std::string outer;    ///< file as the user wrote it
  std::string name;     ///< of the recording in it
  bool picked = false;  ///< --topic NAME has picked it
};

/// The copy that leave_copy() kept of this file, or null: who asked for its memory, or reads it block after block,
/// comes back, and unpacking takes longer than reading. Given: `outer` as it is now, and the name of the recording in
/// it.
std::unique_ptr<TemporaryFile> take_copy(const std::string& outer, const std::string& name);
/// Keeps one copy, the last, until it is taken or the program ends.
void leave_copy(const std::string& outer, const std::string& name, std::unique_ptr<TemporaryFile> copy);

/// The format of the copy. Throws Error::bad_file, also for a packed file in a packed file.
const Format& format_of(const PackedFile& packed, const ReadOptions& options = {});

/// Read a packed file as the functions of Format do. Origin and checksum are those of `outer`.
Recording read(const PackedFile& packed, const ReadOptions& options, const Progress& progress);
std::uintmax_t memory(const PackedFile& packed, const ReadOptions& options);
void stream(const PackedFile& packed, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress);

}  // namespace tumble::file
