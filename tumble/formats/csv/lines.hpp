#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/formats/csv/encoding.hpp"
#include "tumble/formats/file/input_file.hpp"

namespace tumble::csv {

/// A text file as large pieces that end with whole lines, without a copy of any line.
class Lines {
 public:
  /// Given  encoding  its name, or empty: by the bytes
  /// Throws Error::bad_file.
  explicit Lines(const std::string& path, const std::string& encoding = {});

  /// The next piece, as UTF-8 without byte order mark; it ends with a line break (added where the file's last line has
  /// none) and `number_padding` bytes around it may be read. Empty at the end.
  std::string_view next();

  std::size_t size() const { return file_.size(); }  ///< [bytes] of the file
  std::size_t done() const { return done_; }         ///< [bytes] read so far
  const Encoding& encoding() const { return encoding_; }

 private:
  void fill();
  std::size_t take(char* to, std::size_t room);
  std::size_t take_bytes(char* to, std::size_t room);

  std::string path_;
  file::InputFile file_;
  std::string beginning_;  ///< bytes from which the encoding was seen, until they are used
  Encoding encoding_;
  std::optional<Decoder> decoder_;
  std::string decoded_;           ///< text that waits for room
  std::size_t decoded_used_ = 0;  ///< [bytes] of it that are used
  std::vector<char> buffer_;
  std::size_t begin_, end_;  ///< of what was read and not yet handed out
  std::size_t done_ = 0;
  bool ended_ = false;
};

}  // namespace tumble::csv
