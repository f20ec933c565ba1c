#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include "tumble/formats/temporary_folder.hpp"

namespace tumble::file {

/// A file in a folder of its own below the folder for temporary files, which vanishes with the object.
class TemporaryFile {
 public:
  /// Given   name  of the file, without folders
  ///         from  what its bytes come from, for messages
  /// Throws  Error::bad_file where the folder cannot be made.
  TemporaryFile(const std::string& name, std::string from);
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile();

  /// Throws Error::bad_file, for a full disk too.
  void write(std::string_view bytes);
  /// Everything is in the file now. Throws Error::bad_file.
  void close();

  std::string path() const { return path_.string(); }

 private:
  [[noreturn]] void refuse(int code) const;

  std::string from_;
  TemporaryFolder folder_;
  std::filesystem::path path_;
  std::FILE* file_ = nullptr;
  Unfinished unfinished_;
};

}  // namespace tumble::file
