#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace tumble::file {

/// A regular file opened for reading from the beginning.
class InputFile {
 public:
  /// Throws Error::bad_file: not there, not allowed, a folder, a pipe.
  explicit InputFile(const std::string& path);
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  /// Bytes read, 0 at the end. Throws Error::bad_file.
  std::size_t read(char* to, std::size_t count);
  /// Bytes read from `offset` on, fewer than `count` only at the end; the place of read() stays. Several threads may
  /// read at once. Throws Error::bad_file.
  std::size_t read_at(std::uint64_t offset, char* to, std::size_t count) const;
  std::size_t size() const { return size_; }  ///< [bytes] when it was opened

 private:
  std::string path_;
  int descriptor_ = -1;
  std::size_t size_ = 0;
};

/// Whether the file begins with these bytes, at most 32. Throws as InputFile.
bool begins_with(const std::string& path, std::string_view bytes);

}  // namespace tumble::file
