#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/core/recording.hpp"

namespace tumble {

/// What a file does not say itself.
struct ReadOptions {
  std::optional<double> rate;         ///< [Hz] where the file has no time
  std::map<std::string, Unit> units;  ///< for columns without a unit, by column name
  std::vector<std::string> only;      ///< channels wanted; empty: all
  std::string missing;                ///< a word that stands for a missing sample, besides the blank cell
  /// name[unit] of each column of a text table, where it has no header line or in place of it; "-": not to be read
  std::vector<std::string> columns = {};
  std::string segment_column = {};  ///< of a text table: holds the label of the segment that each sample belongs to
};

/// Consumes a recording block after block. Every call holds the same channels with the next samples.
using BlockSink = std::function<void(const Recording& block)>;

/// Writes a recording block after block to a temporary file beside the target; commit() flushes, checks and renames it.
/// Destroyed without commit, nothing remains.
struct RecordingWriter {
  std::function<void(const Recording& block)> append;
  std::function<void()> commit;
};

/// A catalogue entry of formats/: file <-> Recording. Reading throws Error::bad_file that says what, where and what
/// would be accepted, whatever the bytes are.
struct Format {
  const char* name;
  const char* summary;
  std::vector<std::string> extensions;          ///< ".csv"
  bool (*recognises)(const std::string& path);  ///< by its first bytes
  /// Everything at once, with origin (file, checksum).
  Recording (*read)(const std::string& path, const ReadOptions& options, const Progress& progress);
  /// Bytes that the samples wanted take in memory, about. Throws as read where the file says too little.
  std::uintmax_t (*memory)(const std::string& path, const ReadOptions& options);
  /// For files larger than memory: blocks of about `samples` samples a channel. Without origin.checksum.
  void (*stream)(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
                 const Progress& progress);
  /// Whole or not at all. The first block says which channels there are, and carries marks and meta.
  RecordingWriter (*writer)(const std::string& path);
};

/// All entries, in the order of their names.
const std::vector<const Format*>& format_catalogue();

/// The format of a file, by content, else by extension. Throws Error::bad_file.
const Format& format_of(const std::string& path);
/// In that format; with origin (file, checksum). Throws Error::bad_file.
Recording read_recording(const std::string& path, const ReadOptions& options, const Progress& progress);
/// By extension. Throws Error::bad_input for an unknown one (with those accepted), Error::bad_file when it cannot.
void write_recording(const Recording& recording, const std::string& path);
/// A writer of the format that the extension names. Throws as write_recording().
RecordingWriter recording_writer(const std::string& path);
/// From one file to another, block after block, so that neither has to fit into memory. Throws as the two above.
void convert(const std::string& from, const std::string& to, const ReadOptions& options, const Progress& progress);

}  // namespace tumble
