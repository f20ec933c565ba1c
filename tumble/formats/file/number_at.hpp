#pragma once

#include <algorithm>
#include <bit>
#include <cstring>

namespace tumble::file {

static_assert(std::endian::native == std::endian::little, "numbers are read as they lie in the file");

/// The number at `bytes` of a file, which need not be aligned: its lowest byte first, or last where `reversed`.
template <class Number>
Number number_at(const char* bytes, bool reversed = false) {
  char own[sizeof(Number)];
  std::memcpy(own, bytes, sizeof own);
  if (reversed) std::reverse(own, own + sizeof own);
  return std::bit_cast<Number>(own);
}

}  // namespace tumble::file
