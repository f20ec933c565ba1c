#include "tumble/serve/jobs/folder_below.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

namespace tumble::jobs {
namespace {

constexpr int no_links = O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;

bool is_one_part(const std::string& name) {
  return !name.empty() && name != "." && name != ".." && name.find('/') == std::string::npos &&
         name.find('\0') == std::string::npos;
}

Descriptor opened_folder(const std::string& root) {
  return Descriptor(open(root.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
}

[[noreturn]] void refuse_folder(const std::string& place) {
  throw std::filesystem::filesystem_error("folder", place, std::error_code(errno, std::generic_category()));
}

}  // namespace

Descriptor::~Descriptor() {
  if (number_ >= 0) close(number_);
}

Descriptor folder_below(const std::string& root, const std::vector<std::string>& parts) {
  Descriptor folder = opened_folder(root);
  for (const std::string& part : parts) {
    if (!folder || !is_one_part(part)) return Descriptor();
    folder = Descriptor(openat(folder.number(), part.c_str(), no_links));
  }
  return folder;
}

bool make_folder_below(const std::string& root, const std::string& place, const std::string& name) {
  const Descriptor above = opened_folder(root);
  if (!above) refuse_folder(root);
  if (mkdirat(above.number(), place.c_str(), 0777) != 0 && errno != EEXIST) refuse_folder(place);
  const Descriptor folder(openat(above.number(), place.c_str(), no_links));
  if (!folder) refuse_folder(place);
  if (mkdirat(folder.number(), name.c_str(), 0777) == 0) return true;
  if (errno != EEXIST) refuse_folder(place);
  return false;
}

/// A file system gives the number of a folder that was removed to the next one, and two sticks that were filled alike
/// have the same numbers: the time of its birth is looked at, too, where it is known.
std::uint64_t number_of(const Descriptor& folder) {
  constexpr std::uint64_t odd = 0x9e3779b97f4a7c15;  // mixes what is added
  struct statx status {};
  if (!folder || statx(folder.number(), "", AT_EMPTY_PATH, STATX_INO | STATX_BTIME, &status) != 0) return 0;
  std::uint64_t number = status.stx_ino;
  if ((status.stx_mask & STATX_BTIME) != 0)
    for (const std::uint64_t part :
         {static_cast<std::uint64_t>(status.stx_btime.tv_sec), static_cast<std::uint64_t>(status.stx_btime.tv_nsec)})
      number = (number + part) * odd;
  return number;
}

Descriptor file_in(const Descriptor& folder, const std::string& name) {
  if (!folder || !is_one_part(name)) return Descriptor();
  Descriptor file(openat(folder.number(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (!file || fstat(file.number(), &status) != 0 || !S_ISREG(status.st_mode)) return Descriptor();
  return file;
}

std::vector<std::string> files_in(const Descriptor& folder) {
  std::vector<std::string> files;
  const int own = folder ? openat(folder.number(), ".", no_links) : -1;
  DIR* const list = own >= 0 ? fdopendir(own) : nullptr;
  if (!list) return files;
  while (const dirent* entry = readdir(list)) {
    struct stat status {};
    if (fstatat(own, entry->d_name, &status, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(status.st_mode))
      files.emplace_back(entry->d_name);
  }
  closedir(list);
  std::ranges::sort(files);
  return files;
}

}  // namespace tumble::jobs
