#include "tumble/wire/codec/checksum.hpp"

#include <gtest/gtest.h>

#include <random>

namespace tumble::codec {
namespace {

/// A CRC bit by bit, as it is defined: a division of polynomials.
std::uint32_t crc_by_bits(const FrameChecksum& check, std::string_view bytes) {
  const std::uint64_t top = std::uint64_t{1} << (check.width - 1), mask = 2 * top - 1;
  std::uint64_t crc = check.init;
  for (const unsigned char byte : bytes)
    for (int bit = 0; bit < 8; ++bit) {
      const bool one = byte >> (check.reflected ? bit : 7 - bit) & 1;
      crc = (((crc & top) != 0) != one ? crc << 1 ^ check.poly : crc << 1) & mask;
    }
  std::uint64_t result = 0;
  for (int bit = 0; bit < check.width; ++bit)
    result |= (crc >> bit & 1) << (check.reflected ? check.width - 1 - bit : bit);
  return static_cast<std::uint32_t>(result ^ check.xorout);
}

TEST(FrameChecksum, ACrcIsTheRemainderOfADivision) {
  std::mt19937_64 random(5);
  std::string bytes(41, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  for (const int width : {8, 16, 24, 32})
    for (const bool reflected : {false, true}) {
      const std::uint64_t mask = (std::uint64_t{1} << width) - 1;
      FrameChecksum check{.width = width, .reflected = reflected};
      check.poly = static_cast<std::uint32_t>((random() | 1) & mask);
      check.init = static_cast<std::uint32_t>(random() & mask);
      check.xorout = static_cast<std::uint32_t>(random() & mask);
      check.table = crc_table(check);
      for (std::size_t length = 0; length <= bytes.size(); ++length)
        EXPECT_EQ(checksum_over(check, std::string_view(bytes).substr(0, length)),
                  crc_by_bits(check, std::string_view(bytes).substr(0, length)))
            << width << (reflected ? " reflected, " : " plain, ") << length << " bytes";
    }
}

}  // namespace
}  // namespace tumble::codec
