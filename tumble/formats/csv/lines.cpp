#include "tumble/formats/csv/lines.hpp"

#include <algorithm>
#include <cstring>

#include "tumble/formats/csv/number.hpp"
#include "tumble/units/error.hpp"

namespace tumble::csv {

namespace {

constexpr std::size_t piece = std::size_t{1} << 18;   // stays in the second-level cache between reading and parsing
constexpr std::size_t sample = std::size_t{1} << 16;  // shows the encoding
constexpr std::size_t longest_line = std::size_t{1} << 24;
constexpr std::size_t front = 64;  // >= number_padding
static_assert(front >= number_padding);

}  // namespace

Lines::Lines(const std::string& path, const std::string& encoding)
    : path_(path), file_(path), buffer_(front + piece + front), begin_(front), end_(front) {
  beginning_.resize(std::min(file_.size() + 1, sample));
  std::size_t size = 0;
  while (const std::size_t count = file_.read(beginning_.data() + size, beginning_.size() - size)) size += count;
  beginning_.resize(size);
  encoding_ = encoding_of(beginning_, encoding, path);
  if (!encoding_.plain()) decoder_.emplace(encoding_);
  beginning_.erase(0, encoding_.mark);
  done_ = encoding_.mark;
}

/// Bytes of the file, those of the beginning first; 0 at the end.
std::size_t Lines::take_bytes(char* to, std::size_t room) {
  std::size_t count = std::min(room, beginning_.size());
  std::memcpy(to, beginning_.data(), count);
  beginning_.erase(0, count);
  if (count < room) count += file_.read(to + count, room - count);
  done_ += count;
  return count;
}

/// Bytes of UTF-8; 0 at the end.
std::size_t Lines::take(char* to, std::size_t room) {
  if (!decoder_) return take_bytes(to, room);
  while (decoded_.size() - decoded_used_ < room) {
    decoded_.erase(0, decoded_used_);
    decoded_used_ = 0;
    char bytes[16384];
    const std::size_t count = take_bytes(bytes, sizeof bytes);
    if (count == 0) break;
    decoder_->append({bytes, count}, decoded_);
  }
  const std::size_t count = std::min(room, decoded_.size() - decoded_used_);
  std::memcpy(to, decoded_.data() + decoded_used_, count);
  decoded_used_ += count;
  return count;
}

/// Moves what is left to the front and reads behind it; the buffer grows while one line does not fit.
void Lines::fill() {
  std::memmove(buffer_.data() + front, buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_ - front;
  begin_ = front;
  if (buffer_.size() - end_ < front + piece / 2) buffer_.resize(2 * buffer_.size());
  if (buffer_.size() > longest_line)
    throw Error{Error::Kind::bad_file, say("'{}' is not a text table: a line is longer than 8 MB", path_)};
  const std::size_t room = std::min(piece, buffer_.size() - end_ - front);
  const std::size_t count = take(buffer_.data() + end_, room);
  end_ += count;
  if (count > 0) return;
  ended_ = true;
  if (end_ > begin_ && buffer_[end_ - 1] != '\n') buffer_[end_++] = '\n';
}

std::string_view Lines::next() {
  while (!ended_) {
    const std::size_t searched = end_ - begin_;
    fill();
    const void* last = memrchr(buffer_.data() + begin_ + std::min(searched, end_ - begin_), '\n',
                               end_ - begin_ - std::min(searched, end_ - begin_));
    if (last == nullptr && !ended_) continue;
    if (last == nullptr) break;
    const auto stop = static_cast<std::size_t>(static_cast<const char*>(last) - buffer_.data()) + 1;
    const std::string_view whole(buffer_.data() + begin_, stop - begin_);
    begin_ = stop;
    return whole;
  }
  return {};
}

}  // namespace tumble::csv
