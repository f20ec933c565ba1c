#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "tumble/formats/file/window.hpp"

namespace tumble::mat {

/// The bytes of one variable, plain or packed by zlib.
class Bytes {
 public:
  /// `size` bytes of the file from the place of `window` on; `packed`: they unpack to what is read.
  Bytes(file::Window& window, std::size_t size, bool packed);
  Bytes(const Bytes&) = delete;
  Bytes& operator=(const Bytes&) = delete;
  ~Bytes();

  /// Throws Error::bad_file, the bare reason, where fewer remain.
  void read(char* to, std::size_t count);
  void skip(std::size_t count);
  /// Checks the sum at the end of packed bytes. `read_whole`: nothing but padding may follow what was read. Throws
  /// Error::bad_file, the bare reason.
  void finish(bool read_whole);
  std::size_t position() const { return position_; }  ///< [bytes] that were read or skipped
  /// [bytes] that can follow at most.
  std::size_t most() const;

 private:
  struct Inflater;
  bool step();
  void unpack(char* to, std::size_t count);

  file::Window& window_;
  std::size_t rest_;  ///< [bytes] in the file
  std::size_t position_ = 0;
  std::unique_ptr<Inflater> inflater_;
};

}  // namespace tumble::mat
