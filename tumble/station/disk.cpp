#include "tumble/station/disk.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/station/disk/state.hpp"
#include "tumble/station/disk/vfs.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

struct Disk::Inner {
  explicit Inner(const DiskFault& fault) : state(fault), vfs(state) {}
  disk::State state;
  disk::Vfs vfs;
};

namespace {

[[noreturn]] void refuse_disk_call(const Sentence& what, int code) {
  throw Error(Error::Kind::bad_file, say("{}: {}", what, std::system_category().message(code)));
}

void require_done(disk::Outcome outcome, const Sentence& what) {
  if (outcome != disk::Outcome::done) refuse_disk_call(what, outcome == disk::Outcome::full ? ENOSPC : EIO);
}

/// Opens, works, closes. Returns the code of the error, 0 without.
template <class Work>
int with_descriptor(const std::string& path, int flags, Work work) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
  if (descriptor < 0) return errno;
  const int code = work(descriptor);
  ::close(descriptor);
  return code;
}

int synchronise_descriptor(int descriptor) { return fsync(descriptor) == 0 ? 0 : errno; }

}  // namespace

Disk::Disk(const DiskFault& fault) : inner_(std::make_unique<Inner>(fault)) {}
Disk::~Disk() = default;

const char* Disk::vfs() const { return inner_->vfs.name(); }
std::uint64_t Disk::calls() const { return inner_->state.calls(); }
bool Disk::failed() const { return inner_->state.failed(); }
void Disk::power_cut() { inner_->state.power_cut(); }

void Disk::allocate(const std::string& path, std::uint64_t bytes) {
  require_done(inner_->state.produce(path), say("cannot make '{}'", Name{path}));
  const int code = with_descriptor(path, O_WRONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK, [&](int descriptor) {
    return posix_fallocate(descriptor, 0, static_cast<off_t>(bytes));
  });
  if (code == 0) return;
  unlink(path.c_str());
  refuse_disk_call(say("cannot keep {} bytes free in '{}'", bytes, Name{path}), code);
}

void Disk::produce(const std::string& path, const std::function<void()>& write) {
  require_done(inner_->state.produce(path), say("cannot write '{}'", Name{path}));
  write();
  if (inner_->state.tracks()) inner_->state.produced(path, read_text_file(path));
}

void Disk::synchronise(const std::string& path) {
  require_done(inner_->state.synchronise(path), say("cannot synchronise '{}'", Name{path}));
  if (const int code = with_descriptor(path, O_RDONLY, synchronise_descriptor); code != 0) {
    inner_->state.note_error();
    refuse_disk_call(say("cannot synchronise '{}'", Name{path}), code);
  }
}

void Disk::rename(const std::string& from, const std::string& to) {
  require_done(inner_->state.rename(from, to), say("cannot rename '{}'", Name{from}));
  if (std::rename(from.c_str(), to.c_str()) != 0) refuse_disk_call(say("cannot rename '{}'", Name{from}), errno);
}

void Disk::remove(const std::string& path) {
  require_done(inner_->state.remove(path), say("cannot remove '{}'", Name{path}));
  if (unlink(path.c_str()) != 0 && errno != ENOENT) refuse_disk_call(say("cannot remove '{}'", Name{path}), errno);
}

void Disk::synchronise_folder(const std::string& folder) {
  require_done(inner_->state.synchronise_folder(folder), say("cannot synchronise '{}'", Name{folder}));
  const int code = with_descriptor(folder, O_RDONLY | O_DIRECTORY, synchronise_descriptor);
  if (code == 0 || code == EINVAL) return;  // some file systems have no such call
  inner_->state.note_error();
  refuse_disk_call(say("cannot synchronise '{}'", Name{folder}), code);
}

std::uint64_t Disk::room(const std::string& folder) const {
  std::error_code failed;
  const auto space = std::filesystem::space(folder, failed);
  if (failed) refuse_disk_call(say("cannot find the room of '{}'", Name{folder}), failed.value());
  return space.available;
}

}  // namespace tumble
