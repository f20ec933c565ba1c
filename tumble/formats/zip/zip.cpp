// A recording of any format in a zip archive.

#include <algorithm>
#include <memory>
#include <utility>

#include "tumble/formats/file/packed.hpp"
#include "tumble/formats/zip/archive.hpp"
#include "tumble/units/error.hpp"

namespace tumble::zip {

namespace {

[[noreturn]] void refuse_archive(const std::string& path, const Sentence& reason) {
  throw Error{Error::Kind::bad_file, say("'{}': {}", path, reason)};
}

bool named(const Entry& entry, const std::string& name) {
  return entry.name == name || entry.name.ends_with("/" + name);
}

/// The file to read: the only one, or that which a topic names; the topic is then used up.
Entry chosen(const std::string& path, ReadOptions& options) {
  const auto entries = entries_of(path);
  if (entries.empty()) refuse_archive(path, "a zip archive without files");
  if (std::ranges::any_of(entries, [](const Entry& entry) { return entry.name == "[Content_Types].xml"; }))
    refuse_archive(path, "a workbook or document of an office program; save the sheet as CSV");
  for (auto topic = options.topics.begin(); topic != options.topics.end(); ++topic) {
    const auto entry = std::ranges::find_if(entries, [&](const Entry& one) { return named(one, *topic); });
    if (entry == entries.end()) continue;
    options.topics.erase(topic);
    return *entry;
  }
  if (entries.size() == 1) return entries.front();
  const Sentence all = listed(entries);
  if (options.topics.empty())
    refuse_archive(
        path, say("a zip archive of {} files: {}; pick one: --topic '{}'", entries.size(), all, entries.front().name));
  refuse_archive(path, say("it has no file '{}', but {} files: {}; pick one: --topic '{}'", options.topics.front(),
                           entries.size(), all, entries.front().name));
}

/// A recording of an archive, unpacked into a temporary file.
struct Unpacked {
  Entry entry;
  ReadOptions options;
  std::unique_ptr<file::TemporaryFile> copy;
  bool picked;

  Unpacked(const std::string& path, const ReadOptions& given) : options(given) {
    entry = chosen(path, options);
    picked = options.topics.size() < given.topics.size();
    if ((copy = file::take_copy(path, entry.name))) return;
    copy = std::make_unique<file::TemporaryFile>(entry.name, path);
    unpack(path, entry, [&](std::string_view bytes) { copy->write(bytes); });
    copy->close();
  }
  file::PackedFile packed(const std::string& path) const { return {*copy, path, entry.name, picked}; }
};

Recording read(const std::string& path, const ReadOptions& options, const Progress& progress) {
  const Unpacked file(path, options);
  return file::read(file.packed(path), file.options, progress);
}

std::uintmax_t memory(const std::string& path, const ReadOptions& options) {
  Unpacked file(path, options);
  const auto bytes = file::memory(file.packed(path), file.options);
  file::leave_copy(path, file.entry.name, std::move(file.copy));
  return bytes;
}

void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  Unpacked file(path, options);
  file::stream(file.packed(path), file.options, samples, sink, progress);
  file::leave_copy(path, file.entry.name, std::move(file.copy));
}

}  // namespace

extern const Format zip{.name = "zip",
                        .summary = "one file of any other format, in a zip archive; --topic picks one of several",
                        .extensions = {".zip"},
                        .recognises = is_archive,
                        .read = tumble::zip::read,
                        .memory = memory,
                        .stream = stream};

}  // namespace tumble::zip
