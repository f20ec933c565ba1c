#pragma once

#include <filesystem>
#include <string_view>
#include <utility>

/// Files and folders that no ending of the program leaves behind: a handler of signals removes them, and what SIGKILL leaves, a
/// later run removes. Each is locked by its owner as long as it lives, also in another container or on another computer.
namespace tumble {

/// Remembers a file or an empty folder until it is forgotten or destroyed.
class Unfinished {
 public:
  Unfinished() = default;
  explicit Unfinished(const std::filesystem::path& path);
  Unfinished(Unfinished&& other) noexcept : slot_(std::exchange(other.slot_, -1)) {}
  Unfinished& operator=(Unfinished&& other) noexcept {
    std::swap(slot_, other.slot_);
    return *this;
  }
  ~Unfinished() { forget(); }

  void forget();

 private:
  int slot_ = -1;  ///< where its name is kept; -1: nowhere
};

/// Removes all that is remembered: files, then the folders that are empty by then. For handlers of signals that end the
/// program: it allocates nothing and takes no lock.
void unlink_unfinished() noexcept;

/// Locks an open file or folder for its owner. Where the file system has no locks, it stays as it is, and nobody sweeps it.
void lock_unfinished(int descriptor);

/// Removes what programs that were killed have left in a folder: files and folders of this user whose names begin and end so, that
/// nobody has locked, and that are older than a minute. Once a process for each folder.
void sweep_unfinished(const std::filesystem::path& folder, std::string_view begin, std::string_view end);

}  // namespace tumble
