#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace tumble {

/// File or folder below `root` under a name that a client gave: "sub/day 1.csv". Throws Error::bad_input for a name
/// that is empty, absolute, has "..", control characters or a part that begins with a dot, or that leads outside by a
/// link.
std::filesystem::path inside(const std::filesystem::path& root, const std::string& name);

/// Whether a name can be shown and sent: UTF-8 without control characters.
bool is_plain_name(std::string_view name);

/// A name for a new file in a folder: no folder, no leading dot, at most 200 bytes. Throws Error::bad_input.
void require_file_name(const std::string& name);

/// When a file was changed [s] since 1970-01-01; 0 where that cannot be read.
double modified_of(const std::filesystem::path& path);

/// Makes a folder of the user of this process alone, where it is not there; the path. Throws Error::bad_file where it
/// belongs to another user, or others may write into it: what lies in there would be theirs.
std::filesystem::path own_folder(const std::filesystem::path& path);

/// A folder that one workbench has for itself while this lives: two would give the same numbers to their jobs. No file
/// is written. Throws Error::bad_input where another has it; a file system without locks is taken as it is.
class FolderClaim {
 public:
  explicit FolderClaim(const std::filesystem::path& folder);
  FolderClaim(const FolderClaim&) = delete;
  FolderClaim& operator=(const FolderClaim&) = delete;
  ~FolderClaim();

 private:
  int descriptor_;
};

}  // namespace tumble
