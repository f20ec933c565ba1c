#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tumble/formats/file/input_file.hpp"

namespace tumble::csv {

/// A text file as large pieces that end with whole lines, without a copy of any line.
class Lines {
 public:
  explicit Lines(const std::string& path);

  /// The next piece; it ends with a line break (added where the file's last line has none) and `number_padding` bytes
  /// around it may be read. Empty at the end. The byte order mark of UTF-8 is left out.
  std::string_view next();

  std::size_t size() const { return file_.size(); }  ///< [bytes] of the file
  std::size_t done() const { return done_; }         ///< [bytes] read so far

 private:
  void fill();

  std::string path_;
  file::InputFile file_;
  std::vector<char> buffer_;
  std::size_t begin_, end_;  ///< of what was read and not yet handed out
  std::size_t done_ = 0;
  bool ended_ = false;
};

}  // namespace tumble::csv
