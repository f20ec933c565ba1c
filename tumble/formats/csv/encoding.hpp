#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace tumble::csv {

/// How the characters of a text are written as bytes.
struct Encoding {
  std::string name = "UTF-8";  ///< as iconv knows it
  std::size_t mark = 0;        ///< [bytes] of the byte order mark
  bool recognised = false;     ///< by the bytes alone: neither a byte order mark nor the user says it
  bool return_ends = false;    ///< lines end with CR alone

  /// The bytes can be used without being converted.
  bool plain() const { return name == "UTF-8" && !return_ends; }
};

/// The encoding of a text from its first bytes: by its byte order mark; UTF-16 by its zero bytes; UTF-8 where the bytes
/// are valid; else GB18030 where the bytes above 127 come in pairs as in Chinese text, or Windows-1252.
/// Given     beginning  the first bytes of the file; `said`: a name that iconv knows, or empty
/// Throws    Error::bad_file for a name that is not known
Encoding encoding_of(std::string_view beginning, const std::string& said, const std::string& path);

/// Converts to UTF-8, piece by piece. Bytes that the encoding does not have become U+FFFD.
class Decoder {
 public:
  explicit Decoder(const Encoding& encoding);
  /// Appends the characters of `bytes` to `text`; what a character lacks at the end waits for the next call.
  void append(std::string_view bytes, std::string& text);

 private:
  struct Close {
    void operator()(void* converter) const;
  };
  std::unique_ptr<void, Close> converter_;
  std::string pending_;
  std::size_t step_ = 1;  ///< [bytes] of the smallest unit
  bool return_ends_ = false;
};

/// Whether a file that begins so can be text in one of the encodings: no control characters except tabs and line ends.
bool looks_like_text(std::string_view beginning);

}  // namespace tumble::csv
