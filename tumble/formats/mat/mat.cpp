#include "tumble/formats/checksum.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/mat/recording.hpp"
#include "tumble/units/error.hpp"

namespace tumble::mat {

namespace {

enum class Level { none, four, five, seven };

Level level_of(const std::string& path) {
  char bytes[10];
  const std::string_view head(bytes, file::InputFile(path).read(bytes, sizeof bytes));
  if (head.starts_with("MATLAB 5.0")) return Level::five;
  // MATLAB 7.3 wrote 7.0 at first.
  if (head.starts_with("MATLAB 7.")) return Level::seven;
  return is_level4(path) ? Level::four : Level::none;
}

bool recognises(const std::string& path) { return level_of(path) != Level::none; }

Contents contents_of(const std::string& path, Keep keep) {
  switch (level_of(path)) {
    case Level::four:
      return read_level4(path, keep);
    case Level::five:
      return read_level5(path, keep);
    case Level::seven:
      return read_hdf5(path, keep);
    case Level::none:
      break;
  }
  throw Error(Error::Kind::bad_file, say("'{}' is no binary file of MATLAB: it begins neither with 'MATLAB 5.0' or "
                                         "'MATLAB 7.' nor with a variable of version 4",
                                         path));
}

file::Gathered gather(const std::string& path, const ReadOptions& options, Keep keep, const Progress& progress) {
  if (!options.segment_column.empty())
    throw Error(Error::Kind::bad_file, say("'{}' is a file of MATLAB: segment_column is for text tables", path));
  report(progress, 0.0, "reading");
  return recording_of(contents_of(path, keep), path, options);
}

Recording read(const std::string& path, const ReadOptions& options, const Progress& progress) {
  auto checksum = sha256_in_background(path);
  Recording recording = file::in_memory(gather(path, options, Keep::in_memory, progress));
  recording.origin.checksum = std::move(checksum);
  return recording;
}

/// All arrays: which of them are wanted is known only once all were read.
std::uintmax_t memory(const std::string& path, const ReadOptions&) {
  return sizeof(double) * contents_of(path, Keep::sizes_only).numbers;
}

void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  file::hand_out(gather(path, options, Keep::in_spool, progress), samples, sink, progress);
}

}  // namespace

extern const Format mat{.name = "mat",
                        .summary = "binary file of MATLAB, versions 4, 5 (6, 7) and 7.3: arrays, also in structures",
                        .extensions = {".mat"},
                        .recognises = recognises,
                        .read = read,
                        .memory = memory,
                        .stream = stream};

}  // namespace tumble::mat
