#include "tumble/exchange/certificate_number.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string_view>

namespace tumble {

namespace {

struct CodePoints {
  std::uint32_t first, last;
};

/// What no reader can distinguish from a space or a hyphen, from a plain letter or digit, or see at all.
constexpr CodePoints look_alikes[] = {
    {0x00, 0x1f},     {0x7f, 0xa0},     {0xad, 0xad},     {0x34f, 0x34f},   {0x61c, 0x61c},   {0x115f, 0x1160},
    {0x180b, 0x180e}, {0x2000, 0x2015}, {0x2028, 0x202f}, {0x2043, 0x2043}, {0x205f, 0x206f}, {0x2212, 0x2212},
    {0x3000, 0x3000}, {0x3164, 0x3164}, {0xfe00, 0xfe0f}, {0xfe58, 0xfe58}, {0xfe63, 0xfe63}, {0xfeff, 0xfeff},
    {0xff0d, 0xff0d}, {0xff10, 0xff19}, {0xff21, 0xff3a}, {0xff41, 0xff5a}, {0xffa0, 0xffa0}};

/// The first code point of a text in UTF-8 of up to three bytes, which is taken from it; longer ones as 0xfffd.
std::uint32_t taken_from(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const std::uint32_t lead = byte(0);
  const std::size_t length = lead < 0x80 ? 1 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
  const std::uint32_t code = length == 1   ? lead
                             : length == 2 ? (lead & 0x1f) << 6 | (byte(1) & 0x3f)
                             : length == 3 ? (lead & 0x0f) << 12 | (byte(1) & 0x3f) << 6 | (byte(2) & 0x3f)
                                           : 0xfffd;
  text.remove_prefix(std::min(length, text.size()));
  return code;
}

}  // namespace

Sentence problem_of_certificate_number(const std::string& number) {
  std::uint32_t before = 0;
  for (std::string_view rest = number; !rest.empty();) {
    const std::uint32_t code = taken_from(rest);
    const bool alike = std::ranges::any_of(
        look_alikes, [&](const CodePoints& range) { return range.first <= code && code <= range.last; });
    if (alike)
      return say(
          "certificate number '{}' has the character U+{:04X}, which looks like another one or like none: write plain "
          "letters, digits, single spaces and '-'",
          number, code);
    if (code == ' ' && (before == ' ' || before == 0 || rest.empty()))
      return say("certificate number '{}' has a space that no reader can see: write single spaces only", number);
    before = code;
  }
  return {};
}

}  // namespace tumble
