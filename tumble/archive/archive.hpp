#pragma once

#include <functional>
#include <memory>
#include <string>

namespace tumble {

/// Who does something to an archive, when and why.
struct ArchiveAct {
  std::string who;
  std::string when;  ///< UTC, "2026-11-24T09:00:00Z"
  std::string why;   ///< may be empty, except for corrections
};

/// The history of units: a database, and a folder with the files that it names by their SHA-256. Nothing in it is ever
/// changed or deleted (docs/archive.md).
class Archive {
 public:
  /// Opens an archive. One of an earlier version of the program is brought up to date.
  ///
  /// Given     address  file, or "postgresql://USER@HOST/DATABASE"
  ///           when     UTC, for the note of when it was brought up to date
  /// Throws    Error::bad_input where there is no archive; Error::bad_file where it cannot be opened, is another
  ///           database, or was made by a later version of the program
  explicit Archive(const std::string& address, const std::string& when = {});
  const std::string& address() const;
  const std::string& folder() const;  ///< of its files; empty: they lie in the database

  /// The schema::OpenArchive of the functions of this module.
  void* opened() const { return opened_.get(); }

 private:
  struct Close {
    void operator()(void* opened) const;
  };
  std::unique_ptr<void, Close> opened_;
};

/// In place of a folder: files are kept in the database.
inline constexpr const char* files_in_database = "database";

/// Makes an empty archive.
///
/// Given     address  file that is not there, or an empty database "postgresql://USER@HOST/DATABASE"
///           folder   of its files; empty: beside the file, with `.files` in place of its extension. For a server it
///                    must be a folder that all who use the archive see under this name, or files_in_database
/// Throws    Error::bad_input where there is an archive; Error::bad_file where it cannot be made
void make_archive(const std::string& address, const std::string& folder, const ArchiveAct& act);

}  // namespace tumble
