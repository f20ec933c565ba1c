#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/station/disk.hpp"

namespace tumble::disk {

/// Outcome of a call.
enum class Outcome { done, fails, full, ignored };

/// Calls counted, the fault carried out and, where the fault is a crash, everything remembered that has not been
/// synchronised. Safe to use from several threads.
class State {
 public:
  explicit State(const DiskFault& fault) : fault_(fault) {}

  std::uint64_t calls() const;
  bool failed() const;

  // What is about to happen. `done`: go on; anything else: do not, and report it.
  Outcome open(const std::string& path, bool creates);
  Outcome write(const std::string& path, std::uint64_t offset, std::string_view bytes, std::uint64_t length);
  Outcome truncate(const std::string& path, std::uint64_t length);
  Outcome synchronise(const std::string& path);
  Outcome rename(const std::string& from, const std::string& to);
  Outcome remove(const std::string& path);
  Outcome synchronise_folder(const std::string& folder);
  Outcome produce(const std::string& path);
  /// A file that produce() announced is there with these bytes.
  void produced(const std::string& path, std::string_view bytes);
  /// The system itself reported an error, or a full disk, for a call that was let through.
  void note_error();

  bool tested() const { return fault_.kind != DiskFault::Kind::none; }  ///< the fault decides what survives
  bool tracks() const { return fault_.kind == DiskFault::Kind::crash; }
  void power_cut();

 private:
  struct Change {
    std::uint64_t offset = 0;
    std::string bytes;
    bool truncates = false;  ///< to `offset` bytes
  };
  /// The content of a file: what is on the disk for certain, and what may be.
  struct Content {
    std::string synchronised;
    std::vector<Change> changes;
  };
  using Handle = std::shared_ptr<Content>;
  /// A change of names that is not on the disk for certain: `handle` null removes the name.
  struct Naming {
    std::string name;
    Handle handle;
    bool with_next = false;  ///< the next one happens with it: a renaming is one change
  };

  Outcome next();
  void name(const std::string& path, Handle handle, bool with_next = false);
  Handle content_of(const std::string& path);
  static std::string survived(const Content& content, std::uint64_t& random);

  mutable std::mutex mutex_;
  DiskFault fault_;
  std::uint64_t calls_ = 0;
  bool failed_ = false, full_ = false, crashed_ = false;
  std::uint64_t free_ = 0;  ///< [byte] once the disk is full
  std::map<std::string, Handle> names_, durable_;
  std::vector<Naming> namings_;
};

}  // namespace tumble::disk
