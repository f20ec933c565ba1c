#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "tumble/units/error.hpp"
#include "tumble/wire/codec/content.hpp"
#include "tumble/wire/controller/template.hpp"
#include "tumble/wire/declaration/declared.hpp"

namespace tumble::declaration {

namespace {

int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// "u16", "i24", "f32"
bool parse_type(std::string_view text, FrameNumber& number) {
  int bits = 0;
  const auto [end, code] =
      std::from_chars(text.data() + std::min<std::size_t>(text.size(), 1), text.data() + text.size(), bits);
  if (text.size() < 2 || code != std::errc() || end != text.data() + text.size()) return false;
  const bool real = text[0] == 'f';
  if (text[0] != 'u' && text[0] != 'i' && !real) return false;
  if (bits < 1 || bits > 64 || (real && bits != 32 && bits != 64)) return false;
  number.kind = real             ? FrameNumber::Kind::real
                : text[0] == 'u' ? FrameNumber::Kind::natural
                                 : FrameNumber::Kind::integer;
  number.bytes = (bits + 7) / 8;
  number.bits = bits;
  return true;
}

void read_bits(tables::Section& section, FrameNumber& number) {
  const auto bits = section.integers("bits");
  if (bits.empty()) return;
  const int low = bits.front(), high = bits.back();
  if (bits.size() > 2 || low > high || high >= 8 * number.bytes || number.kind == FrameNumber::Kind::real) {
    section.problem_at(
        "bits", say("the lowest and the highest bit of a whole number are expected, [0, {}]", 8 * number.bytes - 1));
    return;
  }
  number.shift = low;
  number.bits = high - low + 1;
}

/// A number of a line: "decimal", or a type with decimal or hexadecimal digits.
FrameNumber number_of_line(tables::Section& section, std::string_view type) {
  FrameNumber number;
  const auto text = section.text("type").value_or(std::string(type));
  const auto digits = section.text("digits").value_or("decimal");
  if (digits != "decimal" && digits != "hex") section.problem_at("digits", "\"decimal\" or \"hex\" is expected");
  number.form = digits == "hex" ? FrameNumber::Form::hex : FrameNumber::Form::decimal;
  const bool known = text != "decimal" && parse_type(text, number);
  const bool real = number.kind == FrameNumber::Kind::real;
  if (text == "decimal" && digits == "decimal") {
    number.kind = FrameNumber::Kind::real;
    number.bytes = 8;
    number.bits = 64;
  } else if (!known || (real && digits != "hex")) {
    section.problem_at("type", say("'{}' is no type of a cell; decimal (any number), u8, i16, u32 are, and f32 "
                                   "and f64 with digits = \"hex\"",
                                   text));
    number.kind = FrameNumber::Kind::natural;
  }
  read_bits(section, number);
  return number;
}

int item_of(tables::Section& section, std::string_view key, std::uint64_t id, FrameLayout& layout) {
  const auto found = std::ranges::find(layout.items, id, &FrameItem::id);
  if (found != layout.items.end()) return static_cast<int>(found - layout.items.begin());
  if (layout.items.size() == codec::most_items) {
    section.problem_at(key, say("more than {} items in one frame", codec::most_items));
    return 0;
  }
  layout.items.push_back({id, 0});
  return static_cast<int>(layout.items.size()) - 1;
}

}  // namespace

std::string parse_hex(std::string_view text, std::string* mask) {
  std::string bytes;
  int digits = 0, value = 0, fixed = 0;
  for (const char c : text) {
    if (c == ' ' || c == '\n' || c == '\t' || c == '_') continue;
    const bool any = mask && c == '.';
    const int digit = any ? 0 : digit_of(c);
    if (digit < 0)
      throw Error(Error::Kind::bad_input, say("'{}' is no hexadecimal digit; write bytes as \"FE 81\"{}", c,
                                              mask ? ", and .. for a byte that may be any" : ""));
    value = value << 4 | digit;
    fixed = fixed << 4 | (any ? 0 : 15);
    if (++digits % 2 != 0) continue;
    bytes += static_cast<char>(value & 0xff);
    if (mask) *mask += static_cast<char>(fixed & 0xff);
  }
  if (digits % 2 != 0) throw Error(Error::Kind::bad_input, "the last byte has one digit; each byte has two");
  return bytes;
}

std::optional<long long> whole_of(tables::Section& section, std::string_view key) {
  const auto* node = section.find(key);
  if (!node) return std::nullopt;
  if (const auto* integer = node->as_integer();
      integer && integer->get() > -1'000'000'000'000 && integer->get() < 1'000'000'000'000)
    return integer->get();
  section.problem_at(key, "a whole number is expected");
  return std::nullopt;
}

bool order_of(tables::Section& section, bool around) {
  const auto text = section.text("order");
  if (!text) return around;
  if (*text != "big" && *text != "little") section.problem_at("order", "\"big\" or \"little\" is expected");
  return *text == "big";
}

std::string bytes_at(tables::Section& section, std::string_view key) {
  std::string bytes;
  parse_at(section, key, [&] { bytes = controller::latin1(section.text(key).value_or("")); });
  return bytes;
}

FrameCertainty certainty_at(tables::Section& section, FrameCertainty otherwise) {
  const auto text = section.text("certainty");
  if (!text) return otherwise;
  constexpr FrameCertainty all[] = {FrameCertainty::maker, FrameCertainty::crossed, FrameCertainty::driver,
                                    FrameCertainty::computed, FrameCertainty::uncertain};
  for (const auto certainty : all)
    if (*text == name(certainty)) return certainty;
  section.problem_at("certainty", "maker, crossed, driver, computed or uncertain is expected");
  return otherwise;
}

std::vector<const toml::table*> tables_at(tables::Section& section, std::string_view key) {
  std::vector<const toml::table*> found;
  const auto* node = section.find(key);
  if (!node) return found;
  if (const auto* table = node->as_table()) found.push_back(table);
  if (const auto* array = node->as_array())
    for (const auto& element : *array) {
      if (element.as_table())
        found.push_back(element.as_table());
      else
        section.problem_at(key, "a table {key = value, ...}, or a list of them, is expected");
    }
  if (found.empty() && !node->is_array()) section.problem_at(key, "a table {key = value, ...} is expected");
  return found;
}

FrameNumber number_of(tables::Section& section, bool big, std::string_view type, const FrameLayout& layout) {
  if (layout.text) return number_of_line(section, type);
  FrameNumber number;
  const auto text = section.text("type").value_or(std::string(type));
  if (!parse_type(text, number))
    section.problem_at("type", say("'{}' is no type; u8, i16, i24, u32, f32 and f64 are, and u and i with any "
                                   "number of bits up to 64",
                                   text));
  number.big = order_of(section, big);
  const auto at = whole_of(section, "at");
  if (!at && !section.find("at")) section.missing("at", "4");
  if (at && (*at < -8192 || *at > 8192))
    section.problem_at("at", "a byte of the frame is expected, -8192 to 8192");
  else
    number.at = static_cast<int>(at.value_or(0));
  read_bits(section, number);
  return number;
}

std::vector<int> items_of(tables::Section& section, FrameLayout& layout) {
  if (layout.text) return {cell_of(section, layout, 0)};
  std::vector<int> items;
  const char* const key = layout.masks.empty() ? "id" : "bit";
  const auto* node = section.find(key);
  if (!node) return {-1};
  if (!layout.list && layout.masks.empty()) {
    section.problem_at(key, "this frame has no items; it needs items = {...} or masks = [...]");
    return {-1};
  }
  const auto given = section.integers(key);
  if (layout.list)
    for (const int id : given) items.push_back(item_of(section, key, static_cast<std::uint64_t>(id), layout));
  else if (given.size() != 2 || static_cast<std::size_t>(given[0]) >= layout.masks.size() ||
           static_cast<std::size_t>(given[1]) >= layout.masks[static_cast<std::size_t>(given[0])].sizes.size())
    section.problem_at(key, "the index of the mask and the bit are expected, [0, 5]");
  else
    items.push_back(item_of(section, key, static_cast<std::uint64_t>(64 * given[0] + given[1]), layout));
  return items.empty() ? std::vector<int>{-1} : items;
}

void place_number(tables::Section& section, const FrameNumber& number, FrameLayout& layout) {
  if (layout.text) return;
  if (number.item >= 0) {
    FrameItem& item = layout.items[static_cast<std::size_t>(number.item)];
    if (number.at < 0) section.problem_at("at", "in an item the bytes count from its begin, from 0");
    item.size = std::max(item.size, number.at + number.bytes);
    return;
  }
  const int begin = number.at < 0 ? layout.length + number.at : number.at;
  if (begin < 0 || begin + number.bytes > layout.length)
    section.problem_at("at",
                       say("{} bytes at {} do not lie in a frame of {} bytes", number.bytes, number.at, layout.length));
}

}  // namespace tumble::declaration
