#pragma once

#include <string>
#include <string_view>

#include "tumble/formats/unfinished.hpp"

namespace tumble {

/// The name that means standard output.
inline constexpr std::string_view standard_output = "-";

/// A file that appears under its name whole or not at all: a temporary file in the same folder, written, synchronised
/// and renamed by commit(). Destroyed without commit, nothing remains and an earlier file of that name is untouched.
/// A symbolic link is followed; something that is not a file (a pipe, `standard_output`) is written directly.
/// Every member throws Error::bad_file that says what could not be done and where.
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();

  void write(std::string_view bytes);
  void commit();

  /// Where the bytes go until commit(): for libraries that open files by name.
  const std::string& temporary() const { return temporary_; }
  /// False where the target is a device or a pipe, which cannot be replaced.
  bool replaces() const { return temporary_ != target_; }

 private:
  [[noreturn]] void fail(int code) const;

  std::string path_;       ///< as the user wrote it, for messages
  std::string target_;     ///< links resolved
  std::string temporary_;  ///< in the same folder
  int descriptor_ = -1;
  Unfinished unfinished_;
};

/// The whole content at once. Throws Error::bad_file.
void write_file_atomically(const std::string& path, std::string_view content);

/// A text file as a whole. Throws Error::bad_file with the system's reason.
std::string read_text_file(const std::string& path);

}  // namespace tumble
