#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/formats/file/input_file.hpp"

namespace tumble::ros {

enum class Packing { none, bzip2, lz4, zstandard };

/// A stretch of a file, and how its bytes are packed.
struct Piece {
  std::uint64_t begin = 0, size = 0;  ///< [bytes] in the file; of a database the first row and the number of rows
  std::uint64_t unpacked = 0;         ///< [bytes] as the file says
  Packing packing = Packing::none;
  bool counted = false;   ///< an index says which messages are in it
  bool cut = false;       ///< the file ends within it
  std::uint32_t crc = 0;  ///< CRC-32 of the unpacked bytes, as the file says; 0: it does not
  std::size_t part = 0;   ///< of a log of several files, the one that it lies in
};

/// The bytes of a piece, unpacked, seen through a window of bounded size: sizes that a file states wrongly cost no
/// memory. It is used again for one piece after the other.
class Window {
 public:
  static constexpr std::size_t longest = 65536;  ///< [bytes] that may be taken at once

  Window();
  ~Window();
  Window(Window&&) noexcept;

  /// Given: ahead [bytes], how many are read at once from a piece that is not packed.
  void open(const file::InputFile& file, const Piece& piece, std::size_t ahead = 262144);
  /// The next `count` bytes, at most `longest`, which stay until the next call; null where fewer remain. Throws
  /// Error::bad_file, the bare reason, where the piece cannot be unpacked.
  const char* take(std::size_t count);
  /// Passes over `count` bytes; false where fewer remain. Throws as take().
  bool skip(std::uint64_t count);
  bool at_end() { return next_ == end_ && !refill(1); }
  /// [bytes] taken or skipped.
  std::uint64_t position() const;
  /// False where all bytes have passed, and their CRC is not that of the piece.
  bool crc_agrees() const;
  /// Bytes read at once from now on.
  void read_ahead(std::size_t bytes);

 private:
  struct State;
  bool refill(std::size_t count);
  std::unique_ptr<State> state_;
  const char* next_ = nullptr;
  const char* end_ = nullptr;
};

inline const char* Window::take(std::size_t count) {
  if (static_cast<std::size_t>(end_ - next_) < count && !refill(count)) return nullptr;
  const char* const bytes = next_;
  next_ += count;
  return bytes;
}

/// Thrown where what was read of a piece is not to be used.
struct Untrusted {
  std::string reason;
};

/// Whether a message was packed by itself with Zstandard, as rosbag2 does with `--compression-mode message`.
bool is_packed(std::string_view message);
/// Unpacks it into `room`. Empty where it is damaged or longer than any message that is read.
std::string_view unpacked(std::string_view message, std::vector<char>& room);

}  // namespace tumble::ros
