#include "tumble/tasks/kind_of_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "tumble/formats/format.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// The first bytes of a file.
std::string begin_of(const std::string& path) {
  constexpr std::size_t enough = 4096;
  std::string text(enough, '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

/// The first line that is neither blank nor a comment.
std::string_view first_line(std::string_view text) {
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    auto line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
    if (!line.empty() && line.front() != '#') return line;
  }
  return {};
}

/// Whether a line begins a table of TOML, or gives a key its value.
bool reads_like_toml(std::string_view line) {
  if (line.starts_with('[')) return true;
  const auto key = line.substr(0, line.find_first_of("=,;\t"));
  return key.size() < line.size() && line[key.size()] == '=';
}

bool is_recording(const std::string& path) try {
  format_of(path);
  return true;
} catch (const Error&) {
  return false;
}

}  // namespace

FileKind kind_of_file(const std::string& path) try {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(path, unknown)) return FileKind::unknown;
  if (std::filesystem::path(path).extension() == ".toml") return FileKind::plan;
  const std::string text = begin_of(path);
  const auto line = first_line(text);
  if (line.starts_with('{')) return text.find("\"tumble\"") == text.npos ? FileKind::unknown : FileKind::result;
  if (reads_like_toml(line)) return FileKind::plan;
  return is_recording(path) ? FileKind::recording : FileKind::unknown;
} catch (const Error&) {  // it cannot be read: whoever needs it says why
  return FileKind::unknown;
}

void refuse_other_kind(const std::string& path, FileKind wanted) {
  const FileKind kind = kind_of_file(path);
  if (kind == wanted || kind == FileKind::unknown) return;
  const Name name{path};
  const auto refuse = [](Sentence text) { throw Error(Error::Kind::bad_input, std::move(text)); };
  if (kind == FileKind::recording && wanted == FileKind::plan)
    refuse(say("{} is a recording; the method or the plan comes first: tumble identify allan_noise {}", name, name));
  if (kind == FileKind::recording)
    refuse(say("{} is a recording, and a result is needed: tumble identify allan_noise {} -o result.json", name, name));
  if (kind == FileKind::result)
    refuse(say("{} is a result, and a plan is needed; to read the result: tumble report {}", name, name));
  refuse(say("{} is a plan, and a result is needed: tumble identify {} -o result.json", name, name));
}

}  // namespace tumble
