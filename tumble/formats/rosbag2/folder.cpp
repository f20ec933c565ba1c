#include "tumble/formats/rosbag2/folder.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <tuple>

#include "tumble/units/error.hpp"

namespace tumble::rosbag2 {
namespace {

namespace fs = std::filesystem;

/// Name without its number, and the number by its digits: shorter ones first.
std::tuple<std::string, std::size_t, std::string> order_of(const std::string& path) {
  const std::string name = fs::path(path).stem().string();
  std::size_t begin = name.size();
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(name[begin - 1]))) --begin;
  return {name.substr(0, begin), name.size() - begin, name.substr(begin)};
}

bool is_kind(const fs::path& file) { return file.extension() == ".db3" || file.extension() == ".mcap"; }

bool is_packed(const fs::path& file) {
  return (file.extension() == ".zstd" || file.extension() == ".zst") && is_kind(file.stem());
}

}  // namespace

bool is_folder_of_bag(const std::string& path) {
  std::error_code problem;
  if (!fs::is_regular_file(fs::path(path) / "metadata.yaml", problem)) return false;
  for (fs::directory_iterator file(path, problem), end; !problem && file != end; file.increment(problem))
    if (is_kind(file->path()) || is_packed(file->path())) return true;
  return false;
}

std::vector<std::string> files_of_bag(const std::string& folder) {
  std::vector<std::string> files;
  std::string kind;
  std::error_code problem;
  for (fs::directory_iterator file(folder, problem), end; !problem && file != end; file.increment(problem)) {
    if (is_packed(file->path()))
      throw Error{Error::Kind::bad_file,
                  say("'{}' is packed as a whole: unpack it with `zstd -d --rm`", file->path().string())};
    if (!is_kind(file->path())) continue;
    files.push_back(file->path().string());
    const std::string extension = file->path().extension().string();
    if (!kind.empty() && extension != kind)
      throw Error{Error::Kind::bad_file,
                  say("the folder '{}' holds files of two kinds, .db3 and .mcap: name the one to be read", folder)};
    kind = extension;
  }
  if (files.empty()) throw Error{Error::Kind::bad_file, say("the folder '{}' holds no .db3 or .mcap file", folder)};
  std::ranges::sort(files, {}, order_of);
  return files;
}

}  // namespace tumble::rosbag2
