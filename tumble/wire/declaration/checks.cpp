#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "tumble/units/error.hpp"
#include "tumble/wire/codec/checksum.hpp"
#include "tumble/wire/declaration/declared.hpp"

namespace tumble::declaration {

namespace {

using tables::Section;

std::uint32_t hex_of(Section& section, std::string_view key, int width) {
  const auto text = section.text(key);
  if (!text) return 0;
  std::uint32_t value = 0;
  parse_at(section, key, [&] {
    std::string digits(*text);
    if (digits.size() % 2 != 0) digits.insert(0, 1, '0');
    const std::string bytes = parse_hex(digits);
    if (bytes.empty() || bytes.size() > static_cast<std::size_t>(width / 8))
      throw Error(Error::Kind::bad_input, say("{} hexadecimal digits are expected", width / 4));
    for (const unsigned char byte : bytes) value = value << 8 | byte;
  });
  return value;
}

void read_ranges(Section& section, FrameChecksum& check) {
  const auto end_of = [](const toml::node& node) -> std::optional<int> {
    if (const auto* integer = node.as_integer(); integer && std::abs(integer->get()) <= 8192)
      return static_cast<int>(integer->get());
    if (const auto* text = node.as_string(); text && text->get() == "end") return 0;
    return std::nullopt;
  };
  const auto add = [&](const toml::node& node) {
    const auto* pair = node.as_array();
    const bool two = pair && pair->size() == 2;
    const auto from = two ? end_of((*pair)[0]) : std::nullopt, to = two ? end_of((*pair)[1]) : std::nullopt;
    if (from && to)
      check.over.emplace_back(*from, *to);
    else
      section.problem_at("over",
                         "the first byte and the byte after the last are expected, [0, 32], [2, -2] or "
                         "[6, \"end\"], or a list of these");
  };
  const auto* node = section.find("over");
  if (!node) return section.missing("over", "[0, -4]");
  const auto* array = node->as_array();
  if (array && !array->empty() && (*array)[0].is_array())
    for (const auto& element : *array) add(element);
  else
    add(*node);
}

/// The words of `kind`, and the width that each has where nothing else is said.
bool set_kind(const std::string& kind, FrameChecksum& check) {
  using Kind = FrameChecksum::Kind;
  if (kind == "crc")
    check.kind = Kind::crc, check.width = 16;
  else if (kind == "sum")
    check.kind = Kind::sum, check.width = 8;
  else if (kind == "xor")
    check.kind = Kind::exclusive_or, check.width = 8;
  else if (kind == "fletcher")
    check.kind = Kind::fletcher, check.width = 16, check.big = true;
  else
    return false;
  return true;
}

/// What a checksum is: kind, width and parameters.
FrameChecksum kind_of_check(Section& section, bool big) {
  FrameChecksum check;
  if (!set_kind(section.text("kind").value_or("crc"), check))
    section.problem_at("kind", "\"crc\", \"sum\", \"xor\" or \"fletcher\" is expected");
  check.big = order_of(section, check.kind == FrameChecksum::Kind::fletcher || big);
  const auto width = section.integer("width").value_or(check.width);
  if (width == 8 || width == 16 || width == 24 || width == 32)
    check.width = width;
  else
    section.problem_at("width", "8, 16, 24 or 32 bits are expected");
  check.init = hex_of(section, "init", check.width);
  if (check.kind == FrameChecksum::Kind::crc) {
    check.poly = hex_of(section, "poly", check.width);
    if (!section.find("poly")) section.missing("poly", "\"1021\"");
    check.xorout = hex_of(section, "xorout", check.width);
    if (const auto* node = section.find("reflected")) check.reflected = node->value_or(false);
    check.pad = section.integer("pad").value_or(0);
    if (check.pad > 8) section.problem_at("pad", "at most 8 bytes"), check.pad = 8;
  }
  if (check.kind == FrameChecksum::Kind::sum) {
    if (const auto* node = section.find("negated")) check.negated = node->value_or(false);
    check.words = section.integer("words").value_or(1);
    if (check.words != 1 && check.words != 2 && check.words != 4)
      section.problem_at("words", "words of 1, 2 or 4 bytes are expected"), check.words = 1;
  }
  check.table = codec::crc_table(check);
  return check;
}

/// Where the checksum of a line is: hexadecimal digits at its end, behind the second of two texts.
void read_between(Section& section, const FrameLayout& layout, FrameChecksum& check) {
  const auto between = section.texts("between");
  if (between.size() == 2 && between[1].size() == 1 && between[0].size() <= 8) {
    check.after = between[0];
    check.before = between[1];
  } else {
    section.problem_at(
        "between",
        "what stands before the first byte that is summed, \"\" for the begin of the line, and the character "
        "behind the last are expected, [\"$\", \"*\"]");
    check.before = "*";
  }
  check.none = section.text("none").value_or("");
  for (const FrameChecksum& other : layout.checks) {
    if (other.before != check.before)
      section.problem_at("between", "all checksums of a line follow the same character");
    if (other.width == check.width)
      section.problem_at("width",
                         "of two checksums of a line the number of digits says which: they need different widths");
  }
}

void read_check(const toml::table& table, bool big, FrameLayout& layout, Declared& declared) {
  Section section = declared.draft.section(table, "check");
  FrameChecksum check = kind_of_check(section, big);
  if (layout.text) {
    read_between(section, layout, check);
  } else {
    read_ranges(section, check);
    check.at = static_cast<int>(std::clamp(whole_of(section, "at").value_or(0), -9000ll, 9000ll));
    if (!section.find("at")) section.missing("at", "-4");
    if (!codec::has_room(check, static_cast<std::size_t>(layout.length)))
      section.problem(say("it does not lie in a frame of {} bytes", layout.length));
  }
  section.close();
  layout.checks.push_back(check);
}

}  // namespace

void read_checks(Section& section, bool big, FrameLayout& layout, Declared& declared) {
  const auto tables = tables_at(section, "check");
  if (!tables.empty()) layout.checks.clear();
  for (const auto* table : tables) read_check(*table, big, layout, declared);
}

}  // namespace tumble::declaration
