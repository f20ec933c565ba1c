#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/error.hpp"
#include "tumble/wire/codec/checksum.hpp"
#include "tumble/wire/codec/encode.hpp"
#include "tumble/wire/codec/line.hpp"
#include "tumble/wire/codec/number.hpp"

namespace tumble::codec {

namespace {

/// A line while it is put together.
struct LineDraft {
  const FrameCodec& codec;
  const FrameLayout& layout;
  std::string base;                ///< empty: a new line
  ItemPlaces places;               ///< of the cells of the base
  std::vector<std::string> cells;  ///< by item

  const FrameCell& cell(const FrameNumber& number) const {
    return layout.text->cells[static_cast<std::size_t>(number.item)];
  }
  std::string& text(const FrameNumber& number) { return cells[static_cast<std::size_t>(number.item)]; }
  /// Whether the line has the cell.
  bool has(const FrameNumber& number) const { return places[static_cast<std::size_t>(number.item)].at >= 0; }
  /// Whether a cell keeps how it is written, as long as it means the same.
  bool keeps(const FrameNumber& number) const { return !base.empty() && !cell(number).format.given; }
};

[[noreturn]] void refuse_cell(const LineDraft& draft, const Name& what, const Sentence& why) {
  throw Error(Error::Kind::bad_input,
              say("{}: frame '{}': {}: {}", Name{draft.codec.name}, draft.layout.name, what, why));
}

/// All bits of a number with digits, as they stand in a cell.
std::string written_word(const FrameNumber& number, const FrameFormat& format, std::uint64_t word) {
  if (number.form == FrameNumber::Form::word) {
    std::string letters;
    for (int shift = 56; shift >= 0; shift -= 8)
      if (const char letter = static_cast<char>(word >> shift & 0xffu)) letters += letter;
    return letters;
  }
  if (number.form == FrameNumber::Form::hex)
    return fmt::format("{:0{}X}", word, format.width > 0 ? format.width : 2 * number.bytes);
  const int above = 64 - 8 * number.bytes;
  const bool negative = number.kind == FrameNumber::Kind::integer && static_cast<std::int64_t>(word << above) < 0;
  const std::uint64_t size = negative ? (~word + 1) & mask_of(8 * number.bytes) : word;
  const std::string sign = negative ? "-" : format.plus ? "+" : "";
  const auto digits = static_cast<std::size_t>(std::max(0, format.width - static_cast<int>(sign.size())));
  return format.zeros ? sign + fmt::format("{:0>{}}", size, digits)
                      : fmt::format("{:>{}}", sign + std::to_string(size), format.width);
}

/// Writes the bits of the number; what else its cell holds stays.
void put_bits(LineDraft& draft, const FrameNumber& number, std::uint64_t bits) {
  std::string& text = draft.text(number);
  const auto before = word_in(number, text);
  const std::uint64_t mask = mask_of(number.bits) << number.shift;
  const std::uint64_t word = (before.value_or(0) & ~mask) | (bits << number.shift & mask);
  if (draft.keeps(number) && before && *before == word) return;
  text = written_word(number, draft.cell(number).format, word & mask_of(8 * number.bytes));
}

void put_raw(LineDraft& draft, const FrameNumber& number, const std::string& what, double raw) {
  std::string& text = draft.text(number);
  if (std::isnan(raw)) {
    if (draft.base.empty()) text = "nan";
    return;
  }
  if (number.form == FrameNumber::Form::decimal && number.kind == FrameNumber::Kind::real) {
    if (!draft.keeps(number) || value_in(number, text) != raw) text = written(draft.cell(number).format, raw);
    return;
  }
  const auto bits = bits_for(number, raw);
  if (!bits) refuse_cell(draft, Name{what}, say("{:g} does not fit into {} bits", raw, number.bits));
  put_bits(draft, number, *bits);
}

/// The parts of the first choice that the line has, the coarse ones as whole numbers.
void put_line_time(LineDraft& draft, double time) {
  std::vector<const FrameTime*> parts;
  for (const FrameTime& part : draft.layout.time)
    if (draft.has(part.number) && (parts.empty() || parts.front()->choice == part.choice)) parts.push_back(&part);
  std::ranges::stable_sort(parts, std::ranges::greater{}, [](const FrameTime* part) { return part->factor; });
  for (const FrameTime* part : parts) {
    const double exact = time / part->factor;
    const double raw = part == parts.back() ? exact : std::floor(exact + 1e-9);
    put_raw(draft, part->number, "time", raw);
    time -= raw * part->factor;
  }
}

/// The conditions that say how a new line is: its status is good, and the channels that it carries are in it.
void put_conditions(LineDraft& draft, const std::vector<const FrameField*>& fields) {
  for (const FrameStatus& status : draft.layout.statuses)
    if (status.good.modulus == 0) put_bits(draft, status.good.number, status.good.equals);
  for (const FrameField* field : fields)
    if (field->when && field->when->modulus == 0) put_bits(draft, field->when->number, field->when->equals);
}

/// The fields of the content that the base carries.
std::vector<const FrameField*> fields_in_base(const LineDraft& draft, const FrameContent& content) {
  std::vector<const FrameField*> fields;
  for (const FrameField& field : draft.layout.fields) {
    if (!content.present[field.channel]) continue;
    if (field.when) {
      const FrameNumber& number = field.when->number;
      const auto word = word_in(number, draft.cells[static_cast<std::size_t>(number.item)]);
      if (!word) continue;
      const auto bits = *word >> number.shift & mask_of(number.bits);
      if ((field.when->modulus ? bits % field.when->modulus : bits) != field.when->equals) continue;
    }
    fields.push_back(&field);
  }
  return fields;
}

/// A cell of fixed width with this text.
std::string of_width(const LineDraft& draft, const std::string& text, int width) {
  if (static_cast<int>(text.size()) > width)
    refuse_cell(draft, Name{"'" + text + "'"}, say("does not fit into {} characters", width));
  return fmt::format("{:>{}}", text, width);
}

/// Replaces the cells of the base, the last one first.
std::string over_base(const LineDraft& draft) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < draft.cells.size(); ++i)
    if (draft.places[i].at >= 0) order.push_back(i);
  std::ranges::sort(order, std::ranges::greater{}, [&](std::size_t i) { return draft.places[i].at; });
  std::string line = draft.base;
  for (const std::size_t i : order) {
    const auto at = static_cast<std::size_t>(draft.places[i].at), size = static_cast<std::size_t>(draft.places[i].size);
    const int width = draft.layout.text->cells[i].width;
    if (line.compare(at, size, draft.cells[i]) == 0) continue;
    line.replace(at, size, width > 0 ? of_width(draft, draft.cells[i], width) : draft.cells[i]);
  }
  return line;
}

/// Head, cells, and 0 where a column is skipped; without checksum and end.
std::string new_line(const LineDraft& draft) {
  const FrameText& text = *draft.layout.text;
  std::string line = draft.layout.sync;
  for (int column = 0; column < text.most && column < std::max(text.least, static_cast<int>(text.items.size()));
       ++column) {
    const auto index = static_cast<std::size_t>(column);
    const int item = index < text.items.size() ? text.items[index] : -1;
    if (column > 0) line += text.delimiter;
    line += item < 0 ? "0" : draft.cells[static_cast<std::size_t>(item)];
  }
  if (text.most > 0) return line;
  line.resize(std::max(line.size(), static_cast<std::size_t>(text.length)), ' ');
  for (std::size_t i = 0; i < draft.cells.size(); ++i) {
    const FrameCell& cell = text.cells[i];
    line.replace(static_cast<std::size_t>(cell.at), static_cast<std::size_t>(cell.width),
                 of_width(draft, draft.cells[i], cell.width));
  }
  return line;
}

std::string digits_of(const FrameChecksum& check, std::string_view line) {
  const auto range = summed_range(check, line);
  return fmt::format("{:0{}X}", range ? checksum_over(check, *range) : 0u, check.width / 4);
}

/// Writes the checksum again where it is not right, of the kind that the line has.
void renew_checksum(const FrameLayout& layout, std::string& line) {
  const std::string body(without_end(layout, line));
  const auto mark = body.rfind(layout.checks.front().before);
  if (mark == std::string::npos) return;
  const std::size_t at = mark + layout.checks.front().before.size();
  const std::string digits = body.substr(at);
  for (const FrameChecksum& check : layout.checks) {
    if (!check.none.empty() && digits == check.none) return;
    if (static_cast<int>(digits.size()) != check.width / 4) continue;
    const std::string right = digits_of(check, body);
    const auto same = [](char a, char b) { return (a | 0x20) == (b | 0x20); };
    if (!std::ranges::equal(digits, right, same)) line.replace(at, digits.size(), right);
    return;
  }
}

}  // namespace

std::string written(const FrameFormat& format, double value) {
  std::string spec = "{:";
  if (format.plus) spec += '+';
  if (format.width > 0) spec += (format.zeros ? "0" : "") + std::to_string(format.width);
  if (format.decimals >= 0) spec += "." + std::to_string(format.decimals) + format.style;
  return fmt::format(fmt::runtime(spec + "}"), value);
}

std::string encode_line(const FrameCodec& codec, const FrameContent& content, std::string_view base) {
  const FrameLayout& layout = codec.frames[content.frame];
  LineDraft draft{codec, layout, std::string(base), {}, std::vector<std::string>(layout.items.size(), "0")};
  draft.places.fill({0, 0});
  const bool is_new = base.empty();
  if (!is_new && !locate(layout, base, draft.places))
    throw Error(Error::Kind::bad_input, say("{}: these bytes are no line '{}'", Name{codec.name}, layout.name));
  for (std::size_t i = 0; i < draft.cells.size() && !is_new; ++i)
    if (draft.places[i].at >= 0)
      draft.cells[i] =
          base.substr(static_cast<std::size_t>(draft.places[i].at), static_cast<std::size_t>(draft.places[i].size));
  const auto fields = is_new ? chosen_fields(layout, content) : fields_in_base(draft, content);
  if (is_new) put_conditions(draft, fields);
  if (layout.counter && content.counter && draft.has(layout.counter->number))
    put_bits(draft, layout.counter->number, *content.counter % layout.counter->modulus);
  if (content.time) put_line_time(draft, *content.time);
  for (const FrameField* field : fields)
    if (draft.has(field->number))
      put_raw(draft, field->number, codec.channels[field->channel].name,
              raw_of(*field, content.values[field->channel]));
  if (!is_new) {
    std::string line = over_base(draft);
    if (!layout.checks.empty()) renew_checksum(layout, line);
    return line;
  }
  std::string line = new_line(draft);
  if (!layout.checks.empty()) {
    line += layout.checks.front().before;
    line += digits_of(layout.checks.front(), line);
  }
  return line + layout.end;
}

}  // namespace tumble::codec
