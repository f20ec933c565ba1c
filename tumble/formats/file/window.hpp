#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tumble/formats/file/input_file.hpp"

namespace tumble::file {

/// A file from its beginning to its end, of which a piece of bounded size is in memory.
class Window {
 public:
  static constexpr std::size_t longest = std::size_t{1} << 19;  ///< [bytes] that may be asked for at once

  /// Throws Error::bad_file.
  explicit Window(const std::string& path);

  /// Whether `count` bytes, at most `longest`, follow; they are then at data(). Throws Error::bad_file.
  bool holds(std::size_t count) { return static_cast<std::size_t>(end_ - at_) >= count || refill(count); }
  const char* data() const { return at_; }
  /// Bytes at data() without reading on.
  std::size_t available() const { return static_cast<std::size_t>(end_ - at_); }
  /// Moves on by `count` bytes, or to the end of the file.
  void skip(std::size_t count) {
    if (count <= available()) [[likely]]
      at_ += count;
    else
      skip_on(count);
  }
  std::size_t position() const { return read_ - available(); }  ///< [bytes] of data() from the beginning
  std::size_t size() const { return file_.size(); }             ///< [bytes] of the file

 private:
  bool refill(std::size_t count);
  void skip_on(std::size_t count);

  InputFile file_;
  std::vector<char> buffer_;
  const char* at_;
  const char* end_;
  std::size_t read_ = 0;
};

}  // namespace tumble::file
