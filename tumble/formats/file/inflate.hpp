#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace tumble::file {

/// Takes unpacked bytes, piece by piece.
using ByteSink = std::function<void(std::string_view bytes)>;

/// Unpacks what zlib's deflate packed, piece by piece.
class Inflater {
 public:
  enum class Wrapping { raw, gzip };  ///< gzip: one member after the other
  /// Given: the file, for messages.
  Inflater(Wrapping wrapping, std::string from);
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater();

  /// Throws Error::bad_file for bytes that are damaged.
  void add(std::string_view packed, const ByteSink& sink);
  /// Throws Error::bad_file where the end was not reached: the file was cut off.
  void finish() const;

 private:
  struct State;
  State* state_;
  Wrapping wrapping_;
  std::string from_;
  bool ended_ = false;  ///< at the end of a member
  bool started_ = false;
  bool padding_ = false;  ///< zeros behind the last member
};

}  // namespace tumble::file
