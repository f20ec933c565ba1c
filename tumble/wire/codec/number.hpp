#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "tumble/wire/frames.hpp"

namespace tumble::codec {

/// The bytes at `from` as one natural number.
inline std::uint64_t word_of(const unsigned char* from, int bytes, bool big) {
  std::uint64_t word = 0;
  if (big)
    for (int i = 0; i < bytes; ++i) word = word << 8 | from[i];
  else
    for (int i = bytes; i-- > 0;) word = word << 8 | from[i];
  return word;
}

inline void put_word(std::uint64_t word, unsigned char* to, int bytes, bool big) {
  for (int i = 0; i < bytes; ++i) to[big ? bytes - 1 - i : i] = static_cast<unsigned char>(word >> (8 * i));
}

inline std::uint64_t mask_of(int bits) { return bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1; }

/// The bits of the number, as a natural number.
inline std::uint64_t natural_of(const FrameNumber& number, const unsigned char* from) {
  return word_of(from, number.bytes, number.big) >> number.shift & mask_of(number.bits);
}

/// The value [1] that the bits of the number mean, before any scale.
inline double value_of_bits(const FrameNumber& number, std::uint64_t bits) {
  if (number.kind == FrameNumber::Kind::natural) return static_cast<double>(bits);
  if (number.kind == FrameNumber::Kind::real)
    return number.bytes == 4 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)))
                             : std::bit_cast<double>(bits);
  const int above = 64 - number.bits;
  return static_cast<double>(static_cast<std::int64_t>(bits << above) >> above);
}

/// The value [1] of a number, before any scale.
inline double value_of(const FrameNumber& number, const unsigned char* from) {
  return value_of_bits(number, natural_of(number, from));
}

/// Writes the bits of the number; what stands beside them in its bytes stays.
inline void put_natural(const FrameNumber& number, std::uint64_t bits, unsigned char* to) {
  const std::uint64_t mask = mask_of(number.bits) << number.shift;
  const std::uint64_t word = word_of(to, number.bytes, number.big);
  put_word((word & ~mask) | (bits << number.shift & mask), to, number.bytes, number.big);
}

}  // namespace tumble::codec
