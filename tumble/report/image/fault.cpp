#include "tumble/report/image/fault.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <pugixml.hpp>
#include <vector>

namespace tumble::image {
namespace {

constexpr const char* no_size = "its width or height is zero";
constexpr const char* no_points = "it has no points";

std::string ends_early(std::string_view picture) {
  return fmt::format("it ends early, after {} bytes: it is truncated or damaged", picture.size());
}

std::string damaged_at(std::size_t place) { return fmt::format("it is damaged at byte {}", place); }

/// The bytes of a picture in order. What would lie behind the last of them is zero, and `ended` says so.
struct Bytes {
  std::string_view all;
  std::size_t at = 0;
  bool ended = false;

  std::string_view take(std::size_t count) {
    ended = ended || count > all.size() - at;
    const auto some = ended ? std::string_view() : all.substr(at, count);
    at += some.size();
    return some;
  }
  unsigned byte() {
    const auto one = take(1);
    return one.empty() ? 0 : static_cast<unsigned char>(one[0]);
  }
  std::uint32_t big_endian(int count) {
    std::uint32_t value = 0;
    for (int i = 0; i < count; ++i) value = value << 8 | byte();
    return value;
  }
};

std::uint32_t checksum_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

/// SOF0 to SOF15 have the size of a JPEG; DHT, JPG and DAC stand among them.
bool is_frame(unsigned marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

/// TEM, RST0 to RST7, SOI, and the zero that follows 0xff among the points of a JPEG.
bool is_alone(unsigned marker) { return marker <= 0x01 || (marker >= 0xd0 && marker <= 0xd8); }

/// Blocks of at most 255 bytes, up to an empty one.
void skip_blocks(Bytes& bytes) {
  while (const unsigned size = bytes.byte()) bytes.take(size);
}

/// Bytes of the table of colours that the flags of a GIF announce.
std::size_t colours_of(unsigned flags) { return flags & 0x80 ? std::size_t{3} << ((flags & 7) + 1) : 0; }

/// The numbers at the beginning of a text, "0 0 120,40"; a unit ends them.
std::vector<double> numbers_of(std::string_view text) {
  std::vector<double> numbers;
  for (double number = 0.0;;) {
    text.remove_prefix(std::min(text.find_first_not_of(", \t\r\n"), text.size()));
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (code != std::errc{}) return numbers;
    numbers.push_back(number);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
}

/// Whether number `index` of an attribute is there and not above zero.
bool is_zero(const pugi::xml_attribute& attribute, std::size_t index) {
  const auto numbers = numbers_of(attribute.value());
  return index < numbers.size() && !(numbers[index] > 0.0);
}

}  // namespace

std::string fault_of_png(std::string_view picture) {
  Bytes bytes{picture, 8};
  for (bool first = true, points = false;; first = false) {
    const std::size_t size = bytes.big_endian(4), begin = bytes.at;
    const auto name = bytes.take(4);
    Bytes content{bytes.take(size)};
    const std::uint32_t checksum = bytes.big_endian(4);
    if (bytes.ended) return ends_early(picture);
    if (checksum != checksum_of(picture.substr(begin, 4 + size)))
      return fmt::format("it is damaged: the checksum of the chunk at byte {} is wrong", begin - 4);
    if (first && name != "IHDR") return damaged_at(begin - 4);
    if (first && (content.big_endian(4) == 0 || content.big_endian(4) == 0)) return no_size;
    points = points || name == "IDAT";
    if (name == "IEND") return points ? "" : no_points;
  }
}

std::string fault_of_jpeg(std::string_view picture) {
  Bytes bytes{picture, 2};
  for (bool frame = false, points = false;;) {
    if (points) bytes.at = std::min(picture.find('\xff', bytes.at), picture.size());
    if (bytes.byte() != 0xff && !bytes.ended) return damaged_at(bytes.at - 1);
    unsigned marker = bytes.byte();
    while (marker == 0xff) marker = bytes.byte();  // as many as one likes may stand before a marker
    if (bytes.ended) return ends_early(picture);
    if (marker == 0xd9) return frame && points ? "" : no_points;
    if (is_alone(marker)) continue;
    const std::size_t size = bytes.big_endian(2);
    Bytes content{bytes.take(std::max<std::size_t>(size, 2) - 2)};
    if (bytes.ended) return ends_early(picture);
    if (is_frame(marker)) {
      content.take(1);
      if (content.big_endian(2) == 0 || content.big_endian(2) == 0) return no_size;
      frame = true;
    }
    points = points || marker == 0xda;
  }
}

std::string fault_of_gif(std::string_view picture) {
  Bytes bytes{picture, 6};
  const auto width = bytes.big_endian(2), height = bytes.big_endian(2);
  const std::size_t colours = colours_of(bytes.byte());
  bytes.take(2 + colours);
  if (!bytes.ended && (width == 0 || height == 0)) return no_size;
  for (bool points = false;;) {
    const unsigned kind = bytes.byte();
    const bool last = kind == 0x3b || (bytes.ended && points);  // some programs do not write the last byte
    if (last) return points ? "" : no_points;
    if (bytes.ended) return ends_early(picture);
    if (kind != 0x21 && kind != 0x2c) return damaged_at(bytes.at - 1);
    points = points || kind == 0x2c;
    bytes.take(kind == 0x2c ? 8 : 1);
    if (kind == 0x2c) bytes.take(colours_of(bytes.byte()) + 1);
    skip_blocks(bytes);
    if (bytes.ended) return ends_early(picture);
  }
}

std::string fault_of_svg(std::string_view picture) {
  pugi::xml_document document;
  const auto read = document.load_buffer(picture.data(), picture.size());
  if (!read) return fmt::format("its XML is truncated or damaged at byte {}", read.offset);
  const pugi::xml_node svg = document.document_element();
  const std::string name = svg.name();
  const auto colon = name.find(':');
  const std::string declared = "xmlns" + (colon == name.npos ? "" : ":" + name.substr(0, colon));
  const std::string_view space = svg.attribute(declared.c_str()).value();
  if (!space.starts_with('&') && space != "http://www.w3.org/2000/svg")  // an entity of the document may be its name
    return "browsers do not draw it, because <svg> lacks xmlns=\"http://www.w3.org/2000/svg\"";
  const auto box = svg.attribute("viewBox");
  const bool zero =
      is_zero(svg.attribute("width"), 0) || is_zero(svg.attribute("height"), 0) || is_zero(box, 2) || is_zero(box, 3);
  return zero ? no_size : "";
}

}  // namespace tumble::image
