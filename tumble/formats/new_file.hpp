#pragma once

#include <string>

#include "tumble/formats/atomic_file.hpp"

namespace tumble {

/// A file that a library makes by name, and that appears under its own name when it is whole: a temporary file in the
/// same folder, which keep() renames, never over another file. Destroyed without keep(), nothing remains.
class NewFile {
 public:
  /// Throws Error::bad_file where the folder cannot be written.
  explicit NewFile(const std::string& path);

  /// Where it is made: the file is there, and empty.
  const std::string& temporary() const { return file_.temporary(); }
  /// After the library has closed it. Returned: false where the name is taken; the other file is as it was.
  /// Throws Error::bad_file.
  bool keep();

  /// Whether something has this name: a file, a folder, also a link that leads nowhere.
  static bool is_taken(const std::string& path);

 private:
  std::string path_;
  AtomicFile file_;
};

/// Synchronises a folder, so that names in it survive a power cut. Some file systems refuse it: what they hold is as
/// safe as they make it.
void synchronise_folder(const std::string& folder);

}  // namespace tumble
