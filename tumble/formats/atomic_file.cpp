#include "tumble/formats/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "tumble/formats/confinement.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/new_file.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace fs = std::filesystem;

namespace {

/// The file a chain of links leads to, which need not exist yet; or the path itself.
fs::path resolved(const fs::path& path) {
  constexpr int longest_chain = 40;  // as the system has it
  fs::path target = path;
  for (int links = 0; links < longest_chain; ++links) {
    std::error_code none;
    const auto next = fs::read_symlink(target, none);
    if (none) return target;
    target = target.parent_path() / next;
  }
  return path;
}

/// A new empty file in the folder of `target`, with the permissions of the file it will replace.
int open_beside(const fs::path& target, std::string& name) {
  sweep_unfinished(target.parent_path().empty() ? "." : target.parent_path(), ".", ".part");
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const auto leaf =
        "." + target.filename().string() + "." + std::to_string(getpid()) + "." + std::to_string(attempt) + ".part";
    name = (target.parent_path() / leaf).string();
    const int descriptor = open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno == EEXIST) continue;
    if (descriptor >= 0) lock_unfinished(descriptor);
    struct stat old {};
    if (descriptor >= 0 && stat(target.c_str(), &old) == 0 && fchmod(descriptor, old.st_mode & 0777) != 0) errno = 0;
    return descriptor;
  }
  errno = EEXIST;
  return -1;
}

}  // namespace

AtomicFile::AtomicFile(const std::string& path) : path_(path), target_(resolved(path).string()) {
  if (path == standard_output) {
    temporary_ = target_;
    descriptor_ = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
    if (descriptor_ < 0) fail(errno);
    return;
  }
  require_contained(path);
  std::error_code ignored;
  const auto status = fs::status(target_, ignored);
  if (fs::is_directory(status)) throw Error{Error::Kind::bad_file, say("cannot write '{}': it is a folder", path)};
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    temporary_ = target_;
    descriptor_ = open(target_.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    descriptor_ = open_beside(target_, temporary_);
  }
  if (descriptor_ < 0) fail(errno);
  if (replaces()) unfinished_ = Unfinished(temporary_);
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      target_(std::move(other.target_)),
      temporary_(std::move(other.temporary_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      unfinished_(std::move(other.unfinished_)) {}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  close(descriptor_);
  if (replaces()) unlink(temporary_.c_str());
}

void AtomicFile::fail(int code) const {
  throw Error{Error::Kind::bad_file, say("cannot write '{}': {}", path_, system_reason(code))};
}

void AtomicFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const auto written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void AtomicFile::commit() {
  if (replaces()) {
    if (fsync(descriptor_) != 0) fail(errno);
    if (rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
    unfinished_.forget();
  }
  if (close(std::exchange(descriptor_, -1)) != 0) fail(errno);
  if (replaces()) synchronise_folder(fs::path(target_).parent_path().string());
}

void write_file_atomically(const std::string& path, std::string_view content) {
  AtomicFile file(path);
  file.write(content);
  file.commit();
}

std::string read_text_file(const std::string& path) {
  constexpr std::size_t most = std::size_t{1} << 29;
  file::InputFile input(path);
  if (input.size() > most)
    throw Error{Error::Kind::bad_file,
                say("cannot read '{}': it has more than 512 MB, which no plan or result has", path)};
  std::string content(input.size() + 1, '\0');  // the one more shows that the file did not grow
  std::size_t filled = 0;
  while (const std::size_t count = input.read(content.data() + filled, content.size() - filled)) {
    filled += count;
    if (filled == content.size()) content.resize(2 * filled);
  }
  content.resize(filled);
  return content;
}

}  // namespace tumble
