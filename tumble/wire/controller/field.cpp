#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "tumble/units/error.hpp"
#include "tumble/wire/controller/template.hpp"
#include "tumble/wire/declaration/scale.hpp"

namespace tumble::controller {

namespace {

[[noreturn]] void refuse_field(std::string_view field, const Sentence& why) {
  throw Error(Error::Kind::bad_input, say("{{{}}}: {}", field, why));
}

/// The whole number at the begin of `text`, which it is removed from.
int take_digits(std::string_view& text) {
  int value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc()) value = 1000;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

/// "i32le": a number in binary.
bool set_binary(std::string_view format, ControllerPiece& piece) {
  struct Type {
    std::string_view name;
    int bytes;
    bool is_signed, is_real;
  };
  constexpr Type types[] = {{"u8", 1, false, false}, {"i8", 1, true, false},   {"u16", 2, false, false},
                            {"i16", 2, true, false}, {"u32", 4, false, false}, {"i32", 4, true, false},
                            {"f32", 4, false, true}};
  piece.big = format.ends_with("be");
  const auto type = piece.big || format.ends_with("le") ? format.substr(0, format.size() - 2) : format;
  for (const auto& known : types)
    if (type == known.name && (type != format || known.bytes == 1)) {
      piece.bytes = known.bytes, piece.is_signed = known.is_signed, piece.is_real = known.is_real;
      return true;
    }
  return false;
}

/// "+07.3f", "04X", "3s"
void set_format(std::string_view format, std::string_view field, ControllerPiece& piece) {
  if (set_binary(format, piece)) return;
  auto rest = format;
  const auto take = [&](char c) { return rest.starts_with(c) ? (rest.remove_prefix(1), true) : false; };
  const auto digits = [&] { return !rest.empty() && rest[0] >= '0' && rest[0] <= '9'; };
  piece.plus = take('+');
  piece.zeros = take('0');
  if (digits()) piece.width = take_digits(rest);
  if (take('.')) piece.precision = digits() ? take_digits(rest) : 1000;
  piece.type = rest.size() == 1 ? rest[0] : '?';
  const bool real = piece.type == 'f' || piece.type == 'e' || piece.type == 'g';
  const bool sound = real || ((piece.type == 'd' || piece.type == 'X') && piece.precision < 0) ||
                     (piece.type == 's' && piece.width > 0 && piece.precision < 0 && !piece.zeros && !piece.plus);
  if (!sound || piece.width > 64 || piece.precision > 17 || (piece.plus && piece.type == 'X'))
    refuse_field(field, say("'{}' is not a format; write for example .4f, 06.1f, +.3f, d, 04X, 3s (three "
                            "characters), u8, i16be, i32le or f32be",
                            format));
  if (real && piece.precision < 0) piece.precision = 6;
  if (piece.zeros && piece.width == 0) refuse_field(field, "a zero in the format wants a width, for example 06.1f");
}

void set_name(std::string_view name, std::string_view field, ControllerPiece& piece) {
  if (const auto mark = name.find('!'); mark != std::string_view::npos) {
    const auto part = name.substr(mark + 1);
    if (part != "sign" && part != "abs") refuse_field(field, "after '!' stands sign or abs");
    piece.part = part == "sign" ? ControllerPiece::Part::sign : ControllerPiece::Part::magnitude;
    name = name.substr(0, mark);
  }
  if (const auto dot = name.find('.'); dot != std::string_view::npos) {
    auto digits = name.substr(dot + 1);
    piece.axis = digits.empty() ? 0 : take_digits(digits);
    if (piece.axis < 1 || piece.axis > 64 || !digits.empty())
      refuse_field(field, "after the point stands the number of the axis, from 1");
    name = name.substr(0, dot);
  }
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  if (name.empty() || !std::ranges::all_of(name, is_letter))
    refuse_field(field, "a name of small letters, digits and _ is expected, for example {position:.4f deg}");
  piece.text = name;
}

/// The unit, with a number of it that one step means.
void set_unit(std::string_view text, ControllerPiece& piece) {
  const declaration::Scale scale = declaration::parse_scale(text, {});
  if (scale.increment) throw Error(Error::Kind::bad_input, "/sample has no meaning here");
  piece.unit = scale.unit;
  piece.factor = scale.factor;
}

void check_default(std::string_view field, const ControllerPiece& piece) {
  if (!piece.otherwise) return;
  if (piece.kind == ControllerPiece::Kind::number) {
    try {
      write_number(piece, value_of_default(piece));
    } catch (const Error& error) {
      refuse_field(field, say("the default after '=' must be a number that fits ({})", error.problems[0]));
    }
  } else if (piece.type == 's' && piece.width > 0 && piece.otherwise->size() != static_cast<std::size_t>(piece.width)) {
    refuse_field(field, say("the default after '=' must have {} characters", piece.width));
  }
}

}  // namespace

ControllerPiece parse_field(std::string_view field) {
  ControllerPiece piece;
  auto rest = field;
  if (const auto equals = rest.find('='); equals != std::string_view::npos) {
    piece.otherwise = std::string(rest.substr(equals + 1));
    rest = rest.substr(0, equals);
  }
  std::string_view unit, format;
  if (const auto space = rest.find(' '); space != std::string_view::npos)
    unit = rest.substr(space + 1), rest = rest.substr(0, space);
  const auto colon = rest.find(':');
  if (colon != std::string_view::npos) format = rest.substr(colon + 1), rest = rest.substr(0, colon);
  set_name(rest, field, piece);
  piece.precision = 6;
  if (colon != std::string_view::npos) piece.precision = -1, set_format(format, field, piece);
  const bool is_text = unit.empty() && (colon == std::string_view::npos || (piece.type == 's' && piece.bytes == 0));
  using Kind = ControllerPiece::Kind;
  piece.kind = piece.text == "_" ? Kind::any : piece.text == "axis" ? Kind::axis : is_text ? Kind::word : Kind::number;
  if (piece.kind != Kind::number && !is_text) refuse_field(field, "only a number has a unit or a format");
  if (piece.kind == Kind::number && piece.type == 's' && piece.bytes == 0)
    refuse_field(field, "a number has no format of a text");
  if (piece.kind != Kind::number && piece.part != ControllerPiece::Part::whole && !is_text)
    refuse_field(field, "only a number has a sign");
  if (piece.part == ControllerPiece::Part::sign) piece.kind = Kind::number;
  if (piece.kind == Kind::number && !unit.empty()) set_unit(unit, piece);
  if (is_text && piece.kind != Kind::number && piece.type != 's') piece.type = 's', piece.width = 0;
  check_default(field, piece);
  return piece;
}

}  // namespace tumble::controller
