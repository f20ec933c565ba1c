#include "tumble/formats/unfinished.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <ctime>
#include <mutex>
#include <set>
#include <string>
#include <system_error>

namespace tumble {

namespace fs = std::filesystem;

namespace {

/// Names, for a signal handler. What finds no room, or whose name is too long, is left to the next run.
constexpr int slots = 64;
char unfinished[slots][4096];
std::atomic<int> state[slots];  ///< 0: free, 1: being written, 2: a name

int remember(const std::string& name) {
  for (int slot = 0; slot < slots && name.size() < sizeof unfinished[0]; ++slot) {
    int expected = 0;
    if (!state[slot].compare_exchange_strong(expected, 1)) continue;
    std::memcpy(unfinished[slot], name.c_str(), name.size() + 1);
    state[slot] = 2;
    return slot;
  }
  return -1;
}

/// Of the first byte, by fcntl and for the open file: the HDF5 library uses flock, SQLite the bytes from 2^30 on, and each would
/// refuse a file that is locked so.
struct flock first_byte(short kind) {
  struct flock lock {};
  lock.l_type = kind;
  lock.l_whence = SEEK_SET;
  lock.l_len = 1;
  return lock;
}

bool is_locked(int descriptor) {
  struct flock lock = first_byte(F_WRLCK);
  return fcntl(descriptor, F_OFD_GETLK, &lock) != 0 || lock.l_type != F_UNLCK;
}

constexpr std::time_t young = 60;  ///< [s] an owner has locked it by then

/// Nobody has it any more: its owner was of this user, and nobody holds its lock. What is young is not even opened.
bool is_abandoned(const fs::path& path) {
  struct stat facts {};
  const bool old = lstat(path.c_str(), &facts) == 0 && facts.st_uid == geteuid() &&
                   std::time(nullptr) - facts.st_mtime > young && (S_ISREG(facts.st_mode) || S_ISDIR(facts.st_mode));
  const int descriptor = old ? open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK) : -1;
  if (descriptor < 0) return false;
  const bool free = !is_locked(descriptor);
  close(descriptor);
  return free;
}

bool is_first_look(const fs::path& folder) {
  static std::mutex mutex;
  static std::set<std::string> looked_at;
  const std::lock_guard lock(mutex);
  return looked_at.insert(folder.string()).second;
}

}  // namespace

Unfinished::Unfinished(const fs::path& path) : slot_(remember(path.string())) {}

void Unfinished::forget() {
  if (const int slot = std::exchange(slot_, -1); slot >= 0) state[slot] = 0;
}

void unlink_unfinished() noexcept {
  for (int slot = 0; slot < slots; ++slot)
    if (state[slot] == 2) unlink(unfinished[slot]);
  for (int slot = 0; slot < slots; ++slot)
    if (state[slot] == 2) rmdir(unfinished[slot]);
}

void lock_unfinished(int descriptor) {
  const struct flock lock = first_byte(F_RDLCK);
  static_cast<void>(fcntl(descriptor, F_OFD_SETLK, &lock));
}

void sweep_unfinished(const fs::path& folder, std::string_view begin, std::string_view end) {
  if (!is_first_look(folder)) return;
  std::error_code problem;
  std::set<fs::path> abandoned;
  for (fs::directory_iterator entry(folder, problem), none; !problem && entry != none; entry.increment(problem)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with(begin) && name.ends_with(end) && is_abandoned(entry->path())) abandoned.insert(entry->path());
  }
  for (const fs::path& path : abandoned) fs::remove_all(path, problem);
}

}  // namespace tumble
