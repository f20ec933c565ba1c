#pragma once

#include <filesystem>
#include <string>

#include "tumble/formats/unfinished.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble {

/// A folder of its own below the folder for temporary files, which vanishes with the object and with all that is in it. What a
/// program that was killed has left, the next one removes.
class TemporaryFolder {
 public:
  /// Given   failing  what a message says where it cannot be made; the reason follows
  /// Throws  Error::bad_file.
  explicit TemporaryFolder(const Sentence& failing = "a folder for temporary files (TMPDIR) cannot be made");
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;  ///< of the folder, which is locked
  Unfinished unfinished_;
};

}  // namespace tumble
