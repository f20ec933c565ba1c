#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/core/read_options.hpp"
#include "tumble/core/recording.hpp"

namespace tumble {

/// Consumes a recording block after block. Every call holds the same channels with the next samples.
using BlockSink = std::function<void(const Recording& block)>;

/// Writes a recording block after block to a temporary file beside the target; commit() flushes, checks and renames it.
/// Destroyed without commit, nothing remains.
struct RecordingWriter {
  std::function<void(const Recording& block)> append;
  std::function<void()> commit;
};

/// A catalogue entry of formats/: file <-> Recording. Reading throws Error::bad_file that says what, where and what
/// would be accepted, for bytes of any kind. The members up to `read` are enough for a format that is only read.
struct Format {
  const char* name;
  const char* summary;
  std::vector<std::string> extensions;          ///< ".csv"
  bool (*recognises)(const std::string& path);  ///< by its first bytes
  /// Everything at once, with origin (file, checksum).
  Recording (*read)(const std::string& path, const ReadOptions& options, const Progress& progress);
  /// Bytes that the samples wanted take in memory, about. Throws as read where the file says too little. Null: see
  /// recording_memory().
  std::uintmax_t (*memory)(const std::string& path, const ReadOptions& options) = nullptr;
  /// For files larger than memory: blocks of about `samples` samples a channel. Without origin.checksum. Null: see
  /// stream_recording().
  void (*stream)(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
                 const Progress& progress) = nullptr;
  /// Whole or not at all. The first block says which channels there are, and carries marks and meta. Null: files of
  /// this format are only read.
  RecordingWriter (*writer)(const std::string& path) = nullptr;
  bool folders = false;  ///< a folder can be a recording too
  /// Whether the formats without this are asked first: what it recognises may lie inside of their files.
  bool asked_last = false;
};

/// FormatList to choose among.
using FormatList = std::vector<const Format*>;

/// All entries, in the order of their names.
const FormatList& format_catalogue();

/// The format of a file, by content, else by extension. Throws Error::bad_file.
const Format& format_of(const std::string& path, const FormatList& formats = format_catalogue());
/// The format of a file as it is to be read: where `options` name a declaration of frames, that of raw bytes.
/// Throws Error::bad_file.
const Format& format_of(const std::string& path, const ReadOptions& options,
                        const FormatList& formats = format_catalogue());
/// The format that the extension of a target names; CSV for standard output, "-". Throws Error::bad_input for an
/// unknown extension, and for a format that is only read; the message names the formats that can be written.
const Format& format_to_write(const std::string& path, const FormatList& formats = format_catalogue());

/// Bytes that the samples wanted take in memory, about. Of a format that does not say, the size of the file: such a
/// file is read whole in any case, so nothing is gained by reading it twice for an exact answer. Throws as read.
std::uintmax_t recording_memory(const Format& format, const std::string& path, const ReadOptions& options);
/// Blocks of about `samples` samples [1], > 0, of the channel with the most; channels of other rates come in equal
/// shares, so that a block holds about one stretch of time. Without origin.checksum. A file whose format has no stream
/// of its own is read whole and handed out in blocks. Throws as read.
void stream_recording(const Format& format, const std::string& path, const ReadOptions& options, std::size_t samples,
                      const BlockSink& sink, const Progress& progress);

/// The blocks of a recording that is in memory, as stream_recording() hands them out.
void hand_out(const Recording& whole, std::size_t samples, const BlockSink& sink);

/// In the format of the file; with origin (file, checksum). Throws Error::bad_file.
Recording read_recording(const std::string& path, const ReadOptions& options, const Progress& progress,
                         const FormatList& formats = format_catalogue());
/// By extension. Throws as format_to_write(), before anything is written; Error::bad_file when it cannot.
void write_recording(const Recording& recording, const std::string& path,
                     const FormatList& formats = format_catalogue());
/// A writer of the format that the extension names. Throws as write_recording().
RecordingWriter recording_writer(const std::string& path, const FormatList& formats = format_catalogue());
/// From one file to another, block after block, so that neither has to fit into memory (except for a format that can
/// only be read whole). Throws as the two above.
void convert(const std::string& from, const std::string& to, const ReadOptions& options, const Progress& progress,
             const FormatList& formats = format_catalogue());

}  // namespace tumble
