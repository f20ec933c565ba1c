#include "tumble/formats/new_file.hpp"

#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "tumble/units/error.hpp"

namespace tumble {

namespace {

/// Gives a file its name where nothing else has it. Returned: 0, or what errno says. Not every file system knows the
/// first way, nor the second; the third leaves an instant for another program.
int take_free_name(const char* from, const char* to) {
  if (renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  if (link(from, to) == 0) return 0;  // the other name goes with the temporary
  if (errno != EPERM && errno != ENOSYS && errno != EOPNOTSUPP) return errno;
  if (NewFile::is_taken(to)) return EEXIST;
  return rename(from, to) == 0 ? 0 : errno;
}

}  // namespace

void synchronise_folder(const std::string& folder) {
  const int descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

NewFile::NewFile(const std::string& path) : path_(path), file_(path) {}

bool NewFile::is_taken(const std::string& path) {
  struct stat status {};
  return lstat(path.c_str(), &status) == 0;
}

bool NewFile::keep() {
  const int refused = take_free_name(temporary().c_str(), path_.c_str());
  if (refused == EEXIST) return false;
  if (refused != 0) throw Error(Error::Kind::bad_file, say("cannot write '{}': {}", path_, system_reason(refused)));
  synchronise_folder(std::filesystem::path(path_).parent_path().string());
  return true;
}

}  // namespace tumble
