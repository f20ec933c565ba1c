#pragma once

#include <cstddef>
#include <cstdint>

#include "tumble/formats/file/number_at.hpp"

namespace tumble::topics {

/// How a number lies in a message, little endian.
enum class Number : unsigned char { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };

/// [bytes]
constexpr std::size_t size_of(Number number) {
  constexpr unsigned char sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return sizes[static_cast<std::size_t>(number)];
}

constexpr bool is_integer(Number number) { return number != Number::f32 && number != Number::f64; }

/// The number at `at` [as written].
inline double number_at(const char* at, Number number) {
  switch (number) {
    case Number::i8:
      return file::number_at<std::int8_t>(at);
    case Number::u8:
      return file::number_at<std::uint8_t>(at);
    case Number::i16:
      return file::number_at<std::int16_t>(at);
    case Number::u16:
      return file::number_at<std::uint16_t>(at);
    case Number::i32:
      return file::number_at<std::int32_t>(at);
    case Number::u32:
      return file::number_at<std::uint32_t>(at);
    case Number::i64:
      return static_cast<double>(file::number_at<std::int64_t>(at));
    case Number::u64:
      return static_cast<double>(file::number_at<std::uint64_t>(at));
    case Number::f32:
      return file::number_at<float>(at);
    case Number::f64:
      break;
  }
  return file::number_at<double>(at);
}

}  // namespace tumble::topics
