#pragma once

#include <filesystem>
#include <string>

namespace tumble {

/// While it lives, this process opens nothing outside of one folder because a document says so: plans, stations and
/// laboratories that somebody else wrote are data. An empty folder confines nothing. What was before comes back.
class Confinement {
 public:
  explicit Confinement(const std::filesystem::path& folder);
  Confinement(const Confinement&) = delete;
  Confinement& operator=(const Confinement&) = delete;
  ~Confinement();

 private:
  std::filesystem::path before_;
};

/// The variable of the environment by which a program confines those that it starts.
inline constexpr const char* confinement_variable = "TUMBLE_CONFINED_TO";

/// The folder of the Confinement; empty: the process is not confined.
std::filesystem::path confined_to();

/// The file that a document names: an absolute path, or one from the folder of the document on.
///
/// Throws  Error::bad_input where the process is confined, and the file lies outside, or a link on the way leads there.
///         The message does not depend on what is outside
std::string file_named_in(const std::filesystem::path& folder, const std::string& name);

/// Whether file_named_in() would give this path.
bool may_be_named(const std::filesystem::path& path);

/// For all that opens files: a path in the folder of the Confinement must not leave it by a link.
/// Throws Error::bad_file.
void require_contained(const std::string& path);

/// For all that opens a database: SQLite writes into files beside it, which it finds by their names. They are files of
/// their own there, no links to others. Throws Error::bad_file.
void require_own_journals(const std::string& database);

/// Where a path leads when all links are followed; it need not exist.
std::filesystem::path with_links_followed(const std::filesystem::path& path);

/// Whether a path lies in a folder, or is it, by their names.
bool lies_below(const std::filesystem::path& path, const std::filesystem::path& folder);

}  // namespace tumble
