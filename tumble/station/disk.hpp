#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace tumble {

/// A fault of the disk, for tests of what survives. A call is what changes the disk: a write, a synchronisation, a
/// change of a length or of a name.
struct DiskFault {
  enum class Kind {
    none,
    fails,  ///< the call returns an input/output error
    full,   ///< from this call on there is no room; what is removed makes room again
    crash   ///< power cut: the call and all later ones do nothing; see Disk::power_cut()
  };
  Kind kind = Kind::none;
  std::uint64_t at = 0;    ///< number of the call, from 1
  std::uint64_t seed = 0;  ///< of a crash: which of the writes that were not synchronised reached the disk
};

/// The disk as the recorder writes to it: every byte of the live store, of the reserve and of the sealed file goes
/// through one of these. It counts the calls, carries out a fault for tests, and remembers failures: after an
/// input/output error it refuses everything, because a synchronisation that is repeated after an error reports
/// success although data are lost. A full disk is not such an error: nothing was written, and room can be made.
class Disk {
 public:
  explicit Disk(const DiskFault& fault = {});
  Disk(const Disk&) = delete;
  Disk& operator=(const Disk&) = delete;
  ~Disk();  ///< no database may be open on it

  /// The SQLite VFS whose files lie on this disk.
  const char* vfs() const;
  std::uint64_t calls() const;
  bool failed() const;  ///< an error or a crash happened: it refuses everything

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

  /// After a crash: changes the files to what the power cut left of them. What was synchronised is there, and a random
  /// part of what was not.
  void power_cut();

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

}  // namespace tumble
