#include "tumble/recorder/testing/disk_state.hpp"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace tumble::testing {

namespace fs = std::filesystem;

namespace {

/// SplitMix64: enough to choose what a power cut leaves.
std::uint64_t draw(std::uint64_t& state) {
  std::uint64_t z = state += 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string folder_of(const std::string& path) { return fs::path(path).parent_path().string(); }

std::uint64_t size_of(const std::string& path) {
  std::error_code unknown;
  const auto size = fs::file_size(path, unknown);
  return unknown ? 0 : size;
}

}  // namespace

std::uint64_t DiskState::calls() const {
  const std::lock_guard lock(mutex_);
  return calls_;
}

bool DiskState::failed() const {
  const std::lock_guard lock(mutex_);
  return failed_ || crashed_;
}

Outcome DiskState::next() {
  if (crashed_) return Outcome::ignored;
  if (failed_) return Outcome::fails;
  if (++calls_ != fault_.at) return Outcome::done;
  switch (fault_.kind) {
    case DiskFault::Kind::fails:
      failed_ = true;
      return Outcome::fails;
    case DiskFault::Kind::full:
      full_ = true;
      return Outcome::done;
    case DiskFault::Kind::crash:
      crashed_ = true;  // the call itself is remembered as one that was not synchronised
      return Outcome::ignored;
    case DiskFault::Kind::none:
      break;
  }
  return Outcome::done;
}

/// The content behind a name; what lies there when it is first seen counts as synchronised.
DiskState::Handle DiskState::content_of(const std::string& path) {
  Handle& handle = names_[path];
  if (handle) return handle;
  handle = std::make_shared<Content>();
  if (fs::exists(path)) {
    handle->synchronised = bytes_of(path);
    durable_[path] = handle;
  } else {
    namings_.push_back({path, handle});
  }
  return handle;
}

void DiskState::name(const std::string& path, Handle handle, bool with_next) {
  if (handle)
    names_[path] = handle;
  else
    names_.erase(path);
  namings_.push_back({path, std::move(handle), with_next});
}

Outcome DiskState::open(const std::string& path, bool creates) {
  const std::lock_guard lock(mutex_);
  if (crashed_) return Outcome::ignored;
  if (failed_ && creates) return Outcome::fails;
  if (tracks() && creates) content_of(path);
  return Outcome::done;
}

Outcome DiskState::write(const std::string& path, std::uint64_t offset, std::string_view bytes, std::uint64_t length) {
  const std::lock_guard lock(mutex_);
  const bool alive = !crashed_;
  const Outcome outcome = next();
  if (tracks() && alive) content_of(path)->changes.push_back({offset, std::string(bytes)});
  if (outcome != Outcome::done || !full_) return outcome;
  const std::uint64_t end = offset + bytes.size(), growth = end > length ? end - length : 0;
  if (growth > free_) return Outcome::full;
  free_ -= growth;
  return Outcome::done;
}

Outcome DiskState::truncate(const std::string& path, std::uint64_t length) {
  const std::lock_guard lock(mutex_);
  const bool alive = !crashed_;
  const Outcome outcome = next();
  if (tracks() && alive) content_of(path)->changes.push_back({length, {}, true});
  return outcome;
}

Outcome DiskState::synchronise(const std::string& path) {
  const std::lock_guard lock(mutex_);
  const Outcome outcome = next();
  if (outcome == Outcome::done && tracks()) {
    Content& content = *content_of(path);
    content.synchronised = bytes_of(path);
    content.changes.clear();
  }
  return outcome;
}

Outcome DiskState::synchronise_folder(const std::string& folder) {
  const std::lock_guard lock(mutex_);
  const Outcome outcome = next();
  if (outcome != Outcome::done || !tracks()) return outcome;
  std::erase_if(namings_, [&](const Naming& naming) {
    if (folder_of(naming.name) != folder) return false;
    if (naming.handle)
      durable_[naming.name] = naming.handle;
    else
      durable_.erase(naming.name);
    return true;
  });
  return outcome;
}

Outcome DiskState::rename(const std::string& from, const std::string& to) {
  const std::lock_guard lock(mutex_);
  const bool alive = !crashed_;
  const Outcome outcome = next();
  if (!tracks() || !alive) return outcome;
  const Handle handle = content_of(from);
  if (fs::exists(to)) content_of(to);
  name(to, handle, true);
  name(from, nullptr);
  return outcome;
}

Outcome DiskState::remove(const std::string& path) {
  const std::lock_guard lock(mutex_);
  const bool alive = !crashed_;
  const Outcome outcome = next();
  if (outcome == Outcome::done && full_) free_ += size_of(path);
  if (!tracks() || !alive || !fs::exists(path)) return outcome;
  content_of(path);
  name(path, nullptr);
  return outcome;
}

Outcome DiskState::produce(const std::string& path) {
  const std::lock_guard lock(mutex_);
  const bool alive = !crashed_;
  const Outcome outcome = next();
  if (tracks() && alive) content_of(path);
  return outcome == Outcome::done && full_ ? Outcome::full : outcome;
}

void DiskState::produced(const std::string& path, std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  if (!tracks()) return;
  const Handle handle = std::make_shared<Content>();
  handle->changes.push_back({0, std::string(bytes)});
  name(path, handle);
}

void DiskState::note_error() {
  const std::lock_guard lock(mutex_);
  failed_ = true;
}

/// What is synchronised, and of the changes after it a random choice: all up to one of them, or any of them. The last
/// one taken may be torn.
std::string DiskState::survived(const Content& content, std::uint64_t& random) {
  std::string bytes = content.synchronised;
  const bool any = draw(random) % 2 == 0;
  const std::size_t most = any ? content.changes.size() : draw(random) % (content.changes.size() + 1);
  for (std::size_t i = 0; i < most; ++i) {
    const Change& change = content.changes[i];
    if (any && draw(random) % 2 == 0) continue;
    if (change.truncates) {
      bytes.resize(change.offset);
      continue;
    }
    const bool torn = draw(random) % 4 == 0 || i + 1 == most;
    const std::size_t size = torn ? draw(random) % (change.bytes.size() + 1) : change.bytes.size();
    if (bytes.size() < change.offset + size) bytes.resize(change.offset + size);
    bytes.replace(change.offset, size, change.bytes, 0, size);
  }
  return bytes;
}

void DiskState::power_cut() {
  const std::lock_guard lock(mutex_);
  std::uint64_t random = fault_.seed;
  std::size_t happened = draw(random) % (namings_.size() + 1);
  while (happened > 0 && happened < namings_.size() && namings_[happened - 1].with_next) ++happened;
  for (std::size_t i = 0; i < happened; ++i)
    if (namings_[i].handle)
      durable_[namings_[i].name] = namings_[i].handle;
    else
      durable_.erase(namings_[i].name);
  for (const auto& [path, handle] : names_) fs::remove(path);
  for (const auto& naming : namings_) fs::remove(naming.name);
  for (const auto& [path, handle] : durable_) {
    const std::string bytes = survived(*handle, random);
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
}

}  // namespace tumble::testing
