#include "tumble/formats/file/input_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "tumble/formats/confinement.hpp"
#include "tumble/units/error.hpp"

namespace tumble::file {

namespace {

[[noreturn]] void refuse(const std::string& path, const Sentence& reason) {
  throw Error{Error::Kind::bad_file, say("cannot read '{}': {}", path, reason)};
}

[[noreturn]] void refuse(const std::string& path, int code) { refuse(path, system_reason(code)); }

}  // namespace

InputFile::InputFile(const std::string& path) : path_(path) {
  require_contained(path);
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) refuse(path, errno);
  if (S_ISDIR(status.st_mode)) refuse(path, "it is a folder");
  if (!S_ISREG(status.st_mode)) refuse(path, "it is not a regular file (a pipe or device cannot be read twice)");
  descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) refuse(path, errno);
  size_ = static_cast<std::size_t>(status.st_size);
  posix_fadvise(descriptor_, 0, 0, POSIX_FADV_SEQUENTIAL);
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::size_t InputFile::read(char* to, std::size_t count) {
  for (;;) {
    const auto got = ::read(descriptor_, to, count);
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR) refuse(path_, errno);
  }
}

std::size_t InputFile::read_at(std::uint64_t offset, char* to, std::size_t count) const {
  std::size_t done = 0;
  while (done < count && offset + done < size_) {
    const auto got = pread(descriptor_, to + done, count - done, static_cast<off_t>(offset + done));
    if (got == 0) break;
    if (got < 0 && errno != EINTR) refuse(path_, errno);
    if (got > 0) done += static_cast<std::size_t>(got);
  }
  return done;
}

bool begins_with(const std::string& path, std::string_view bytes) {
  char first[32];
  const std::size_t count = InputFile(path).read(first, bytes.size());
  return std::string_view(first, count) == bytes;
}

}  // namespace tumble::file
