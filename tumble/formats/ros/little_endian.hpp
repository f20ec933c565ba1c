#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

namespace tumble::ros {

/// A number as the bytes of a file hold it, first byte lowest.
template <class Number>
Number number_at(const char* bytes) {
  static_assert(std::endian::native == std::endian::little);
  Number number;
  std::memcpy(&number, bytes, sizeof number);
  return number;
}

inline std::uint32_t reversed(std::uint32_t bits) { return __builtin_bswap32(bits); }
inline std::uint64_t reversed(std::uint64_t bits) { return __builtin_bswap64(bits); }

}  // namespace tumble::ros
