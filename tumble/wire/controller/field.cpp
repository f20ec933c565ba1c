#include <fmt/format.h>

#include <algorithm>

#include "tumble/units/error.hpp"
#include "tumble/wire/controller/template.hpp"
#include "tumble/wire/declaration/format.hpp"
#include "tumble/wire/declaration/scale.hpp"

namespace tumble::controller {

namespace {

constexpr int most_characters = 64;  ///< of a number or a text
constexpr int most_decimals = 17, usual_decimals = 6;

[[noreturn]] void refuse_field(std::string_view field, const Sentence& why) {
  throw Error(Error::Kind::bad_input, say("{{{}}}: {}", Name{std::string(field)}, why));
}

/// "i32le": a number in binary.
bool set_binary(std::string_view format, FrameNumber& number) {
  using Kind = FrameNumber::Kind;
  struct Type {
    std::string_view name;
    int bytes;
    Kind kind;
  };
  constexpr Type types[] = {{"u8", 1, Kind::natural},  {"i8", 1, Kind::integer},  {"u16", 2, Kind::natural},
                            {"i16", 2, Kind::integer}, {"u32", 4, Kind::natural}, {"i32", 4, Kind::integer},
                            {"f32", 4, Kind::real}};
  const bool big = format.ends_with("be");
  const auto type = big || format.ends_with("le") ? format.substr(0, format.size() - 2) : format;
  for (const auto& known : types)
    if (type == known.name && (type != format || known.bytes == 1)) {
      number = {.kind = known.kind, .bytes = known.bytes, .bits = 8 * known.bytes, .big = big};
      return true;
    }
  return false;
}

/// The number that a letter of a format means: f, e, g, d, X, s for a text.
std::optional<FrameNumber> number_of_letter(char letter) {
  using Form = FrameNumber::Form;
  if (letter == 'f' || letter == 'e' || letter == 'g') return ControllerPiece().number;
  if (letter == 'd')
    return FrameNumber{.kind = FrameNumber::Kind::integer, .bytes = 8, .bits = 64, .form = Form::decimal};
  if (letter == 'X') return FrameNumber{.bytes = 8, .bits = 64, .form = Form::hex};
  if (letter == 's') return FrameNumber{.form = Form::word};
  return std::nullopt;
}

bool is_text(const FrameNumber& number) { return number.form == FrameNumber::Form::word; }

/// Whether a format makes sense for a number of its letter.
bool is_sound(const FrameNumber& number, const FrameFormat& format) {
  if (format.width > most_characters || format.decimals > most_decimals) return false;
  if (number.kind == FrameNumber::Kind::real) return true;
  if (format.decimals >= 0) return false;
  if (is_text(number)) return format.width > 0 && !format.zeros && !format.plus;
  return number.form == FrameNumber::Form::decimal || !format.plus;
}

/// "+07.3f", "04X", "3s"
void set_format(std::string_view text, std::string_view field, ControllerPiece& piece) {
  if (set_binary(text, piece.number)) return;
  auto rest = text;
  const auto format = declaration::take_format(rest, most_characters);
  const auto number = rest.size() == 1 ? number_of_letter(rest[0]) : std::nullopt;
  if (!format || !number || !is_sound(*number, *format))
    refuse_field(field, say("'{}' is not a format; write for example .4f, 06.1f, +.3f, d, 04X, 3s (three "
                            "characters), u8, i16be, i32le or f32be",
                            text));
  piece.number = *number;
  piece.format = *format;
  if (number->kind == FrameNumber::Kind::real) {
    piece.format.style = rest[0];
    if (format->decimals < 0) piece.format.decimals = usual_decimals;
  }
  if (format->zeros && format->width == 0) refuse_field(field, "a zero in the format wants a width, for example 06.1f");
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
    piece.axis = declaration::take_whole(digits, 64).value_or(0);
    if (piece.axis < 1 || !digits.empty()) refuse_field(field, "after the point stands the number of the axis, from 1");
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
  } else if (is_text(piece.number) && piece.format.width > 0 &&
             piece.otherwise->size() != static_cast<std::size_t>(piece.format.width)) {
    refuse_field(field, say("the default after '=' must have {} characters", piece.format.width));
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
  piece.format.decimals = usual_decimals;
  if (colon != std::string_view::npos) set_format(format, field, piece);
  const bool is_word = unit.empty() && (colon == std::string_view::npos || is_text(piece.number));
  using Kind = ControllerPiece::Kind;
  piece.kind = piece.text == "_" ? Kind::any : piece.text == "axis" ? Kind::axis : is_word ? Kind::word : Kind::number;
  if (piece.kind != Kind::number && !is_word) refuse_field(field, "only a number has a unit or a format");
  if (piece.kind == Kind::number && is_text(piece.number)) refuse_field(field, "a number has no format of a text");
  if (piece.kind != Kind::number && piece.part != ControllerPiece::Part::whole && !is_word)
    refuse_field(field, "only a number has a sign");
  if (piece.part == ControllerPiece::Part::sign) piece.kind = Kind::number;
  if (piece.kind == Kind::number && !unit.empty()) set_unit(unit, piece);
  if (is_word && piece.kind != Kind::number && !is_text(piece.number)) piece.number = {.form = FrameNumber::Form::word};
  check_default(field, piece);
  return piece;
}

}  // namespace tumble::controller
