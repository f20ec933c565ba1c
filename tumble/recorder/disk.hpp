#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "tumble/units/sentence.hpp"

namespace tumble {

/// A call that changes the disk.
struct DiskCall {
  enum class Kind { produce, synchronise, synchronise_folder, rename, remove };
  Kind kind = Kind::produce;
  const std::string& path;
  const std::string& to;  ///< the new name; of other calls the path
};

/// Stands between a Disk and the system, for tests of what survives a fault (testing/faulty_disk.hpp). Without members
/// nothing does.
struct DiskTap {
  enum class Outcome {
    done,    ///< the system is called
    fails,   ///< refused as an input/output error
    full,    ///< refused as a full disk
    ignored  ///< power cut: refused as an input/output error, and nothing happens any more
  };
  std::function<Outcome(const DiskCall&)> before = {};
  std::function<void(const std::string& path)> produced = {};  ///< the file of a call `produce` is there
  std::function<void()> failed = {};                           ///< the system itself reported an error
  std::function<bool()> has_failed = {};
  std::string vfs = {};  ///< of SQLite, for the files of databases; empty: that of the system
};

/// The disk as the recorder writes to it: every byte of the live store, of the reserve and of the sealed file goes
/// through one of these. It remembers failures: after an input/output error it refuses everything, because a
/// synchronisation that is repeated after an error reports success although data are lost. A full disk is not such an
/// error: nothing was written, and room can be made.
class Disk {
 public:
  explicit Disk(DiskTap tap = {});
  Disk(const Disk&) = delete;
  Disk& operator=(const Disk&) = delete;

  /// The SQLite VFS whose files lie on this disk; null: that of the system.
  const char* vfs() const { return tap_.vfs.empty() ? nullptr : tap_.vfs.c_str(); }
  bool failed() const;  ///< an error happened: it refuses everything
  /// A database reports an input/output error of a file on this disk.
  void note_failure();

  // The functions below throw Error::bad_file with the system's reason.

  /// A file of that many bytes, whose room is taken.
  void allocate(const std::string& path, std::uint64_t bytes);
  /// A new file that `write` makes whole under the name given; one call.
  void produce(const std::string& path, const std::function<void()>& write);
  void synchronise(const std::string& path);
  void rename(const std::string& from, const std::string& to);
  void remove(const std::string& path);  ///< a file that is not there is no error
  void synchronise_folder(const std::string& folder);
  /// [byte] that may still be written to the file system of the folder.
  std::uint64_t room(const std::string& folder) const;

 private:
  /// Refuses the call, in words `what`, where the disk has failed, or the tap refuses it.
  void begin(const DiskCall& call, const Sentence& what);

  DiskTap tap_;
  std::atomic<bool> failed_ = false;
};

}  // namespace tumble
