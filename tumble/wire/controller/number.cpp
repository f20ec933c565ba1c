#include "tumble/wire/codec/number.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "tumble/units/error.hpp"
#include "tumble/wire/codec/encode.hpp"
#include "tumble/wire/controller/template.hpp"

namespace tumble::controller {

namespace {

[[noreturn]] void does_not_fit(const ControllerPiece& piece, double steps) {
  throw Error(Error::Kind::bad_input,
              say("{} = {:.9g}{}{} does not fit the format of the controller", Name{key_of(piece)},
                  steps * piece.factor, piece.unit.text() == "1" ? "" : " ", Name{piece.unit.text()}));
}

std::string write_binary(const ControllerPiece& piece, double steps) {
  const FrameNumber& number = piece.number;
  const auto bits = codec::bits_for(number, steps);
  if (!bits || !std::isfinite(codec::value_of_bits(number, *bits))) does_not_fit(piece, steps);
  std::string bytes(static_cast<std::size_t>(number.bytes), '\0');
  codec::put_word(*bits, reinterpret_cast<unsigned char*>(bytes.data()), number.bytes, number.big);
  return bytes;
}

std::optional<double> take_binary(const ControllerPiece& piece, std::string_view& bytes) {
  const auto size = static_cast<std::size_t>(piece.number.bytes);
  if (bytes.size() < size) return std::nullopt;
  const double value = codec::value_of(piece.number, reinterpret_cast<const unsigned char*>(bytes.data()));
  bytes.remove_prefix(size);
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Characters of a decimal number at the begin: sign, digits, point, digits, exponent.
std::size_t length_of_decimal(std::string_view text) {
  std::size_t at = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
  std::size_t digits = 0;
  while (at < text.size() && is_digit(text[at])) ++at, ++digits;
  if (at < text.size() && text[at] == '.')
    for (++at; at < text.size() && is_digit(text[at]); ++at) ++digits;
  if (digits == 0) return 0;
  if (at + 1 < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    std::size_t end = at + 1 + (text[at + 1] == '-' || text[at + 1] == '+' ? 1 : 0);
    const std::size_t first = end;
    while (end < text.size() && is_digit(text[end])) ++end;
    if (end > first) at = end;
  }
  return at;
}

std::size_t length_of_hex(std::string_view text) {
  const auto end = text.find_first_not_of("0123456789ABCDEFabcdef");
  return std::min(end, text.size());
}

/// Digits behind the point, in a number without an exponent.
bool has_decimals(std::string_view text, int precision) {
  const auto point = text.find('.');
  const auto decimals = point == std::string_view::npos ? 0 : text.size() - point - 1;
  return decimals == static_cast<std::size_t>(std::max(precision, 0)) && text.find_first_of("eE") == text.npos;
}

std::optional<double> parse_decimal(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

bool is_hex(const ControllerPiece& piece) { return piece.number.form == FrameNumber::Form::hex; }

/// Decimal digits without point.
bool is_whole(const ControllerPiece& piece) {
  return piece.number.form == FrameNumber::Form::decimal && piece.number.kind == FrameNumber::Kind::integer;
}

std::string written_digits(const ControllerPiece& piece, double steps) {
  const FrameFormat& format = piece.format;
  const int width = format.width;
  std::string text;
  if (is_whole(piece) || is_hex(piece)) {
    const double whole = std::nearbyint(steps);
    if (!(std::abs(whole) <= 9e15) || (is_hex(piece) && whole < 0.0)) does_not_fit(piece, steps);
    const auto number = static_cast<long long>(whole);
    if (is_hex(piece))
      return format.zeros ? fmt::format("{:0{}X}", number, width) : fmt::format("{:{}X}", number, width);
    text = format.plus ? fmt::format("{:+}", number) : fmt::format("{}", number);
  } else {
    FrameFormat plain = format;
    plain.width = 0;
    text = codec::written(plain, steps);
    if (text[0] == '-' && text.find_first_of("123456789") == text.npos)  // a zero has no sign
      text = codec::written(plain, 0.0);
  }
  const auto missing = static_cast<std::size_t>(std::max(0, width - static_cast<int>(text.size())));
  const bool has_sign = text[0] == '-' || text[0] == '+';
  if (format.zeros) return text.insert(has_sign ? 1 : 0, missing, '0');
  return std::string(missing, ' ') + text;
}

/// The digits at the begin of `bytes`, which they are removed from.
std::optional<double> take_digits(const ControllerPiece& piece, std::string_view& bytes) {
  const FrameFormat& format = piece.format;
  const auto width = static_cast<std::size_t>(format.width);
  if (!format.zeros)
    while (bytes.starts_with(' ')) bytes.remove_prefix(1);
  auto text = format.zeros ? bytes.substr(0, width) : bytes;
  text = text.substr(0, is_hex(piece) ? length_of_hex(text) : length_of_decimal(text));
  const bool fits = !format.zeros || (text.size() == width && (is_hex(piece) || has_decimals(text, format.decimals)));
  if (text.empty() || !fits || (is_whole(piece) && text.find_first_of(".eE") != text.npos)) return std::nullopt;
  bytes.remove_prefix(text.size());
  if (!is_hex(piece)) return parse_decimal(text);
  if (text.size() > 12) return std::nullopt;
  return static_cast<double>(std::strtoull(std::string(text).c_str(), nullptr, 16));
}

}  // namespace

std::string write_number(const ControllerPiece& piece, double si) {
  const double steps = piece.unit.from_si(si) / piece.factor;
  if (!std::isfinite(steps) || std::abs(steps) > 1e30) does_not_fit(piece, steps);
  if (piece.part == ControllerPiece::Part::sign) return steps < 0.0 ? "-" : "";
  const double written = piece.part == ControllerPiece::Part::magnitude ? std::abs(steps) : steps;
  if (is_binary(piece)) return write_binary(piece, written);
  std::string text = written_digits(piece, written);
  if (piece.format.zeros && text.size() != static_cast<std::size_t>(piece.format.width)) does_not_fit(piece, steps);
  return text;
}

std::optional<double> take_number(const ControllerPiece& piece, std::string_view& bytes) {
  if (piece.part == ControllerPiece::Part::sign) {
    const bool minus = bytes.starts_with('-');
    if (minus || bytes.starts_with('+')) bytes.remove_prefix(1);
    return minus ? -1.0 : 1.0;
  }
  const auto steps = is_binary(piece) ? take_binary(piece, bytes) : take_digits(piece, bytes);
  if (!steps || (piece.part == ControllerPiece::Part::magnitude && *steps < 0.0)) return std::nullopt;
  const double si = piece.unit.to_si(*steps * piece.factor);
  return std::isfinite(si) ? std::optional(si) : std::nullopt;
}

double resolution(const ControllerPiece& piece, double si) {
  const double step = std::abs(piece.unit.factor() * piece.factor);
  const double steps = std::abs(piece.unit.from_si(si) / piece.factor);
  const bool is_real = piece.number.kind == FrameNumber::Kind::real;
  const int decimals = piece.format.decimals;
  double half = 0.5;
  if (is_real && is_binary(piece))
    half = std::ldexp(steps, -24);
  else if (is_real && piece.format.style == 'f')
    half = 0.5 * std::pow(10.0, -decimals);
  else if (is_real)
    half = 0.5 * steps * std::pow(10.0, piece.format.style == 'e' ? -decimals : 1 - std::max(decimals, 1));
  return step * (half + 4e-16 * steps) + 4e-16 * std::abs(si);
}

double value_of_default(const ControllerPiece& piece) {
  const auto steps = parse_decimal(piece.otherwise.value_or("0"));
  if (!steps) throw Error(Error::Kind::bad_input, say("'{}' is not a number", *piece.otherwise));
  return piece.unit.to_si(*steps * piece.factor);
}

}  // namespace tumble::controller
