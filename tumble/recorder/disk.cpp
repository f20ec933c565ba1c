#include "tumble/recorder/disk.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "tumble/units/error.hpp"

namespace tumble {

namespace {

[[noreturn]] void refuse_disk_call(const Sentence& what, int code) {
  throw Error(Error::Kind::bad_file, say("{}: {}", what, system_reason(code)));
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

Disk::Disk(DiskTap tap) : tap_(std::move(tap)) {}

bool Disk::failed() const { return failed_ || (tap_.has_failed && tap_.has_failed()); }

void Disk::note_failure() {
  failed_ = true;
  if (tap_.failed) tap_.failed();
}

void Disk::begin(const DiskCall& call, const Sentence& what) {
  using Outcome = DiskTap::Outcome;
  const Outcome outcome = failed_ ? Outcome::fails : tap_.before ? tap_.before(call) : Outcome::done;
  if (outcome != Outcome::done) refuse_disk_call(what, outcome == Outcome::full ? ENOSPC : EIO);
}

void Disk::allocate(const std::string& path, std::uint64_t bytes) {
  begin({DiskCall::Kind::produce, path, path}, say("cannot make '{}'", Name{path}));
  const int code = with_descriptor(path, O_WRONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK, [&](int descriptor) {
    return posix_fallocate(descriptor, 0, static_cast<off_t>(bytes));
  });
  if (code == 0) return;
  unlink(path.c_str());
  refuse_disk_call(say("cannot keep {} bytes free in '{}'", bytes, Name{path}), code);
}

void Disk::produce(const std::string& path, const std::function<void()>& write) {
  begin({DiskCall::Kind::produce, path, path}, say("cannot write '{}'", Name{path}));
  write();
  if (tap_.produced) tap_.produced(path);
}

void Disk::synchronise(const std::string& path) {
  begin({DiskCall::Kind::synchronise, path, path}, say("cannot synchronise '{}'", Name{path}));
  if (const int code = with_descriptor(path, O_RDONLY, synchronise_descriptor); code != 0) {
    note_failure();
    refuse_disk_call(say("cannot synchronise '{}'", Name{path}), code);
  }
}

void Disk::rename(const std::string& from, const std::string& to) {
  const Sentence what = say("cannot rename '{}'", Name{from});
  begin({DiskCall::Kind::rename, from, to}, what);
  if (std::rename(from.c_str(), to.c_str()) != 0) refuse_disk_call(what, errno);
}

void Disk::remove(const std::string& path) {
  const Sentence what = say("cannot remove '{}'", Name{path});
  begin({DiskCall::Kind::remove, path, path}, what);
  if (unlink(path.c_str()) != 0 && errno != ENOENT) refuse_disk_call(what, errno);
}

void Disk::synchronise_folder(const std::string& folder) {
  const Sentence what = say("cannot synchronise '{}'", Name{folder});
  begin({DiskCall::Kind::synchronise_folder, folder, folder}, what);
  const int code = with_descriptor(folder, O_RDONLY | O_DIRECTORY, synchronise_descriptor);
  if (code == 0 || code == EINVAL) return;  // some file systems have no such call
  note_failure();
  refuse_disk_call(what, code);
}

std::uint64_t Disk::room(const std::string& folder) const {
  std::error_code failed;
  const auto space = std::filesystem::space(folder, failed);
  if (failed) refuse_disk_call(say("cannot find the room of '{}'", Name{folder}), failed.value());
  return space.available;
}

}  // namespace tumble
