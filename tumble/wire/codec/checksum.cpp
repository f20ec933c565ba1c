#include "tumble/wire/codec/checksum.hpp"

#include "tumble/wire/codec/number.hpp"

namespace tumble::codec {

namespace {

const unsigned char* bytes_of(std::string_view text) { return reinterpret_cast<const unsigned char*>(text.data()); }

std::uint32_t reversed(std::uint32_t bits, int width) {
  std::uint32_t result = 0;
  for (int i = 0; i < width; ++i) result |= (bits >> i & 1u) << (width - 1 - i);
  return result;
}

std::uint32_t width_mask(const FrameChecksum& check) { return static_cast<std::uint32_t>(mask_of(check.width)); }

constexpr std::size_t slices = 8;  ///< bytes that a CRC takes in at once, each with a table of its own

std::uint32_t little_word(const unsigned char* from) {
  return static_cast<std::uint32_t>(from[0]) | static_cast<std::uint32_t>(from[1]) << 8 |
         static_cast<std::uint32_t>(from[2]) << 16 | static_cast<std::uint32_t>(from[3]) << 24;
}

/// The entries of the slices, `first` downwards, for the bytes of a word from its lowest.
std::uint32_t sliced(const std::uint32_t* table, std::size_t first, std::uint32_t word) {
  return table[first * 256 + (word & 0xffu)] ^ table[(first - 1) * 256 + (word >> 8 & 0xffu)] ^
         table[(first - 2) * 256 + (word >> 16 & 0xffu)] ^ table[(first - 3) * 256 + (word >> 24)];
}

/// The register of a reflected CRC is shifted right.
std::uint32_t reflected_crc(const std::uint32_t* table, std::uint32_t crc, const unsigned char* from,
                            std::size_t count) {
  for (; count >= slices; from += slices, count -= slices)
    crc = sliced(table, 7, crc ^ little_word(from)) ^ sliced(table, 3, little_word(from + 4));
  for (; count > 0; ++from, --count) crc = crc >> 8 ^ table[(crc ^ *from) & 0xffu];
  return crc;
}

/// Else left, with its bits at the top of the word: its bytes are those of a reflected one in reverse.
std::uint32_t plain_crc(const std::uint32_t* table, std::uint32_t crc, const unsigned char* from, std::size_t count) {
  for (; count >= slices; from += slices, count -= slices)
    crc = sliced(table, 7, __builtin_bswap32(crc) ^ little_word(from)) ^ sliced(table, 3, little_word(from + 4));
  for (; count > 0; ++from, --count) crc = crc << 8 ^ table[crc >> 24 ^ *from];
  return crc;
}

std::uint32_t crc_over(const FrameChecksum& check, std::uint32_t crc, const unsigned char* from, std::size_t count) {
  if (check.reflected) return reflected_crc(check.table.data(), crc, from, count);
  const int below = 32 - check.width;
  return plain_crc(check.table.data(), crc << below, from, count) >> below;
}

std::uint32_t sum_over(const FrameChecksum& check, std::uint32_t sum, std::string_view range) {
  const auto* const from = bytes_of(range);
  const auto words = static_cast<std::size_t>(check.words);
  for (std::size_t i = 0; i + words <= range.size(); i += words)
    sum += static_cast<std::uint32_t>(word_of(from + i, check.words, check.big));
  return sum;
}

/// A checksum while ranges of bytes are taken in.
class RunningSum {
 public:
  explicit RunningSum(const FrameChecksum& check)
      : check_(check), sum_(is_crc() && check.reflected ? reversed(check.init, check.width) : check.init) {}

  void take(std::string_view range) {
    if (is_crc()) {
      sum_ = crc_over(check_, sum_, bytes_of(range), range.size());
    } else if (check_.kind == FrameChecksum::Kind::sum) {
      sum_ = sum_over(check_, sum_, range);
    } else {
      for (const unsigned char byte : range) {
        sum_ ^= byte;
        first_ = (first_ + byte) & 0xffu;
        second_ = (second_ + first_) & 0xffu;
      }
    }
  }

  std::uint32_t result() const {
    constexpr unsigned char zeros[8] = {};
    const std::uint32_t mask = width_mask(check_);
    if (is_crc()) return (crc_over(check_, sum_, zeros, static_cast<std::size_t>(check_.pad)) ^ check_.xorout) & mask;
    if (check_.kind == FrameChecksum::Kind::fletcher) return check_.big ? first_ << 8 | second_ : second_ << 8 | first_;
    return (check_.negated ? 0u - sum_ : sum_) & mask;
  }

 private:
  bool is_crc() const { return check_.kind == FrameChecksum::Kind::crc; }

  const FrameChecksum& check_;
  std::uint32_t sum_, first_ = 0, second_ = 0;
};

}  // namespace

std::vector<std::uint32_t> crc_table(const FrameChecksum& check) {
  if (check.kind != FrameChecksum::Kind::crc) return {};
  std::vector<std::uint32_t> table(slices * 256);
  const bool right = check.reflected;
  const std::uint32_t poly =
      right ? reversed(check.poly, check.width) : (check.poly & width_mask(check)) << (32 - check.width);
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = right ? byte : byte << 24;
    for (int bit = 0; bit < 8; ++bit)
      crc = right ? (crc & 1u ? crc >> 1 ^ poly : crc >> 1) : (crc >> 31 ? crc << 1 ^ poly : crc << 1);
    table[byte] = crc;
  }
  for (std::size_t i = 256; i < table.size(); ++i) {
    const std::uint32_t before = table[i - 256];
    table[i] = right ? before >> 8 ^ table[before & 0xffu] : before << 8 ^ table[before >> 24];
  }
  return table;
}

bool has_room(const FrameChecksum& check, std::size_t length) {
  const int size = static_cast<int>(length);
  const int at = place_in(size, check.at, false);
  if (at < 0 || at + check.width / 8 > size) return false;
  for (const auto& [from, to] : check.over) {
    const int begin = place_in(size, from, false), end = place_in(size, to, true);
    if (begin < 0 || end > size || begin > end) return false;
  }
  return true;
}

std::uint32_t checksum_of(const FrameChecksum& check, std::string_view frame) {
  const int size = static_cast<int>(frame.size());
  RunningSum sum(check);
  for (const auto& [from, to] : check.over) {
    const int begin = place_in(size, from, false);
    sum.take(frame.substr(static_cast<std::size_t>(begin), static_cast<std::size_t>(place_in(size, to, true) - begin)));
  }
  return sum.result();
}

std::uint32_t checksum_over(const FrameChecksum& check, std::string_view range) {
  RunningSum sum(check);
  sum.take(range);
  return sum.result();
}

bool holds(const FrameChecksum& check, std::string_view frame) {
  const auto at = static_cast<std::size_t>(place_in(static_cast<int>(frame.size()), check.at, false));
  return word_of(bytes_of(frame) + at, check.width / 8, check.big) == checksum_of(check, frame);
}

void put_checksum(const FrameChecksum& check, std::string& frame) {
  const auto at = static_cast<std::size_t>(place_in(static_cast<int>(frame.size()), check.at, false));
  put_word(checksum_of(check, frame), reinterpret_cast<unsigned char*>(frame.data()) + at, check.width / 8, check.big);
}

}  // namespace tumble::codec
