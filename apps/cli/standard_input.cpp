#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

constexpr const char* said = "standard input";

/// Never committed: it is removed when the program ends, in any way.
AtomicFile kept_input() {
  if (isatty(STDIN_FILENO) == 1)
    throw Error(Error::Kind::bad_input,
                "-: standard input is a terminal; write `command | tumble ...` or `tumble ... < FILE`");
  AtomicFile kept(std::filesystem::temp_directory_path() / "tumble-standard-input");
  std::array<char, 1 << 16> block;
  for (;;) {
    const auto count = read(STDIN_FILENO, block.data(), block.size());
    if (count == 0) return kept;
    if (count < 0 && errno != EINTR)
      throw Error(Error::Kind::bad_file, say("{}: it cannot be read: {}", said, system_reason(errno)));
    if (count > 0) kept.write({block.data(), static_cast<std::size_t>(count)});
  }
}

std::optional<AtomicFile>& kept() {
  static std::optional<AtomicFile> file;
  return file;
}

}  // namespace

std::string readable(const std::string& path) {
  if (path != "-") return path;
  if (kept()) throw Error(Error::Kind::bad_input, "-: standard input can be read only once");
  return kept().emplace(kept_input()).temporary();
}

std::string as_written(std::string text) {
  if (!kept()) return text;
  const auto& path = kept()->temporary();
  const auto replace = [&](const std::string& what, const std::string& by) {
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what)) text.replace(at, what.size(), by);
  };
  replace("tumble inspect " + path, "tumble inspect -");  // a command to copy
  replace(path, said);
  return text;
}

Recording read_standard_input(const ReadOptions& options, const Progress& progress) {
  auto recording = read_recording(readable("-"), options, progress);
  recording.origin.file = said;
  for (auto& finding : recording.findings) finding.where = as_written(finding.where);
  return recording;
}

}  // namespace tumble::cli
