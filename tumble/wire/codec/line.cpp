#include "tumble/wire/codec/line.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "tumble/units/text_parts.hpp"
#include "tumble/wire/codec/checksum.hpp"
#include "tumble/wire/codec/number.hpp"

namespace tumble::codec {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t'; }

/// Columns as they are found.
struct ColumnNotes {
  const FrameText& text;
  ItemPlaces& places;
  int count = 0;

  void add(std::size_t begin, std::size_t end) {
    const auto column = static_cast<std::size_t>(count++);
    if (column < text.items.size() && text.items[column] >= 0)
      places[static_cast<std::size_t>(text.items[column])] = {static_cast<int>(begin), static_cast<int>(end - begin)};
  }
};

/// The columns of line[at, end); more than `most` are not counted.
int split_columns(const FrameText& text, std::string_view line, std::size_t at, std::size_t end, ItemPlaces& places) {
  ColumnNotes columns{text, places};
  if (text.delimiter != ' ') {
    while (columns.count <= text.most) {
      const void* const next = std::memchr(line.data() + at, text.delimiter, end - at);
      const std::size_t stop = next ? static_cast<std::size_t>(static_cast<const char*>(next) - line.data()) : end;
      columns.add(at, stop);
      if (!next) break;
      at = stop + 1;
    }
    return columns.count;
  }
  while (columns.count <= text.most) {
    while (at < end && is_blank(line[at])) ++at;
    if (at == end) break;
    const std::size_t begin = at;
    while (at < end && !is_blank(line[at])) ++at;
    columns.add(begin, at);
  }
  return columns.count;
}

/// Digits with a sign in front, of which from_chars does not know the +.
std::string_view without_plus(std::string_view cell) {
  return cell.size() > 1 && cell[0] == '+' && cell[1] != '-' ? cell.substr(1) : cell;
}

template <class Number, class... Base>
std::optional<Number> parsed(std::string_view digits, Base... base) {
  Number value = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, code] = std::from_chars(digits.data(), end, value, base...);
  if (code != std::errc() || stop != end) return std::nullopt;
  return value;
}

bool is_missing(std::string_view cell) {
  return cell.empty() ||
         (cell.size() == 3 && (cell[0] | 0x20) == 'n' && (cell[1] | 0x20) == 'a' && (cell[2] | 0x20) == 'n');
}

/// Whether the line has the checksum that its number of digits means.
bool check_holds(const FrameLayout& layout, std::string_view line) {
  const std::string& before = layout.checks.front().before;
  const auto mark = line.rfind(before);
  if (mark == std::string_view::npos) return false;
  const std::string_view digits = line.substr(mark + before.size());
  for (const FrameChecksum& check : layout.checks) {
    if (!check.none.empty() && digits == check.none) return true;
    if (static_cast<int>(digits.size()) != check.width / 4) continue;
    const auto stated = parsed<std::uint32_t>(digits, 16);
    const auto range = summed_range(check, line);
    return stated && range && *stated == checksum_over(check, *range);
  }
  return false;
}

bool readable(const FrameNumber& number, std::string_view line, const ItemPlaces& places) {
  const ItemPlace& cell = places[static_cast<std::size_t>(number.item)];
  return cell.at < 0 ||
         value_in(number, line.substr(static_cast<std::size_t>(cell.at), static_cast<std::size_t>(cell.size)));
}

bool all_readable(const FrameLayout& layout, std::string_view line, const ItemPlaces& places) {
  const auto of_number = [&](const auto& part) { return readable(part.number, line, places); };
  return std::ranges::all_of(layout.fields, of_number) && std::ranges::all_of(layout.time, of_number) &&
         (!layout.counter || of_number(*layout.counter));
}

}  // namespace

std::optional<std::size_t> length_of_line(const FrameLayout& layout, std::string_view bytes) {
  const auto longest = static_cast<std::size_t>(layout.longest);
  const std::size_t most = std::min(bytes.size(), longest);
  std::size_t i = layout.sync.size();
  while (i < most && is_of_line(static_cast<unsigned char>(bytes[i]))) ++i;
  if (i >= most) return i >= longest ? std::nullopt : std::optional<std::size_t>(0);
  if (i == 0) return std::nullopt;
  if (bytes[i] == layout.end.back()) return i + 1;
  if (bytes[i] == '\r') {
    if (i + 1 == bytes.size()) return 0;
    if (bytes[i + 1] == layout.end.back()) return i + 2;
  }
  return i;
}

std::string_view without_end(const FrameLayout& layout, std::string_view line) {
  if (!line.empty() && line.back() == layout.end.back()) line.remove_suffix(1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

bool locate_cells(const FrameLayout& layout, std::string_view line, ItemPlaces& places) {
  const FrameText& text = *layout.text;
  const std::string_view body = without_end(layout, line);
  if (body.size() < layout.sync.size()) return false;
  std::size_t end = body.size();
  if (!layout.checks.empty()) {
    const auto mark = body.rfind(layout.checks.front().before);
    if (mark == std::string_view::npos || mark < layout.sync.size()) return false;
    end = mark;
  }
  if (text.most > 0) {
    const int columns = split_columns(text, body, layout.sync.size(), end, places);
    return columns >= text.least && columns <= text.most;
  }
  if (end < static_cast<std::size_t>(text.length)) return false;
  for (std::size_t i = 0; i < text.cells.size(); ++i) places[i] = {text.cells[i].at, text.cells[i].width};
  return true;
}

bool sound_line(const FrameLayout& layout, std::string_view line) {
  if (line.empty() || line.back() != layout.end.back()) return false;
  if (!layout.checks.empty() && !check_holds(layout, without_end(layout, line))) return false;
  ItemPlaces places;
  return locate(layout, line, places) && (!layout.checks.empty() || all_readable(layout, line, places));
}

std::optional<std::string_view> summed_range(const FrameChecksum& check, std::string_view line) {
  const auto end = line.rfind(check.before);
  const auto mark = check.after.empty() ? 0 : line.find(check.after);
  if (end == std::string_view::npos || mark == std::string_view::npos) return std::nullopt;
  const auto begin = mark + check.after.size();
  if (begin > end) return std::nullopt;
  return line.substr(begin, end - begin);
}

std::uint64_t word_bits(std::string_view word) {
  if (word.size() > 8) return ~std::uint64_t{0};
  std::uint64_t bits = 0;
  for (const unsigned char letter : word) bits = bits << 8 | letter;
  return bits;
}

std::optional<std::uint64_t> word_in(const FrameNumber& number, std::string_view cell) {
  cell = trimmed(cell);
  if (number.form == FrameNumber::Form::word) return word_bits(cell);
  const std::uint64_t mask = mask_of(8 * number.bytes);
  if (number.form == FrameNumber::Form::hex) {
    if (cell.starts_with("0x") || cell.starts_with("0X")) cell.remove_prefix(2);
    const auto word = parsed<std::uint64_t>(cell, 16);
    return word && *word <= mask ? word : std::nullopt;
  }
  cell = without_plus(cell);
  if (number.kind == FrameNumber::Kind::natural) {
    const auto word = parsed<std::uint64_t>(cell);
    return word && *word <= mask ? word : std::nullopt;
  }
  const auto whole = parsed<std::int64_t>(cell);
  if (!whole) return std::nullopt;
  const auto top = static_cast<std::int64_t>(mask >> 1);
  if (*whole > top || *whole < -top - 1) return std::nullopt;
  return static_cast<std::uint64_t>(*whole) & mask;
}

std::optional<double> value_in(const FrameNumber& number, std::string_view cell) {
  if (number.form == FrameNumber::Form::decimal && number.kind == FrameNumber::Kind::real) {
    cell = trimmed(cell);
    const auto value = parsed<double>(without_plus(cell));
    if (value && std::isfinite(*value)) return value;
    return is_missing(cell) ? std::optional(std::nan("")) : std::nullopt;
  }
  if (is_missing(trimmed(cell))) return std::nan("");
  const auto word = word_in(number, cell);
  if (!word) return std::nullopt;
  return value_of_bits(number, *word >> number.shift & mask_of(number.bits));
}

}  // namespace tumble::codec
