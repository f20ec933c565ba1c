#include "tumble/formats/mat/numbers.hpp"

#include <algorithm>
#include <cstring>

#include "tumble/formats/file/number_at.hpp"

namespace tumble::mat {
namespace {

template <class T>
void convert_as(const char* from, bool swapped, std::size_t count, double* to) {
  for (std::size_t k = 0; k < count; ++k, from += sizeof(T)) {
    to[k] = static_cast<double>(file::number_at<T>(from, swapped));
  }
}

}  // namespace

std::size_t size_of(Stored type) {
  static constexpr unsigned char sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

std::optional<Stored> stored_type(std::uint32_t type) {
  switch (type) {
    case 1:
      return Stored::i8;
    case 2:
    case 16:  // UTF-8
      return Stored::u8;
    case 3:
      return Stored::i16;
    case 4:
    case 17:  // UTF-16
      return Stored::u16;
    case 5:
      return Stored::i32;
    case 6:
    case 18:  // UTF-32
      return Stored::u32;
    case 7:
      return Stored::f32;
    case 9:
      return Stored::f64;
    case 12:
      return Stored::i64;
    case 13:
      return Stored::u64;
    default:
      return std::nullopt;
  }
}

void convert(const char* from, Stored type, bool swapped, std::size_t count, double* to) {
  if (type == Stored::f64 && !swapped) {
    std::memcpy(to, from, count * sizeof(double));
    return;
  }
  using Convert = void (*)(const char*, bool, std::size_t, double*);
  static constexpr Convert conversions[] = {
      convert_as<std::int8_t>,  convert_as<std::uint8_t>,  convert_as<std::int16_t>, convert_as<std::uint16_t>,
      convert_as<std::int32_t>, convert_as<std::uint32_t>, convert_as<std::int64_t>, convert_as<std::uint64_t>,
      convert_as<float>,        convert_as<double>};
  conversions[static_cast<std::size_t>(type)](from, swapped, count, to);
}

std::string text_of(const std::vector<double>& codes) {
  std::string text;
  const auto add = [&](unsigned byte) { text += static_cast<char>(byte); };
  for (const double code : codes) {
    const auto c = code >= 0x20 && code < 0x10000 && code != 0x7f && !(code >= 0xd800 && code < 0xe000)
                       ? static_cast<unsigned>(code)
                       : unsigned{'?'};
    if (c < 0x80) {
      add(c);
    } else if (c < 0x800) {
      add(0xc0 | c >> 6);
      add(0x80 | (c & 0x3f));
    } else {
      add(0xe0 | c >> 12);
      add(0x80 | (c >> 6 & 0x3f));
      add(0x80 | (c & 0x3f));
    }
  }
  return text;
}

}  // namespace tumble::mat
