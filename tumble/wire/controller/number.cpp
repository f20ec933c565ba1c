#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>

#include "tumble/units/error.hpp"
#include "tumble/wire/controller/template.hpp"

namespace tumble::controller {

namespace {

[[noreturn]] void does_not_fit(const ControllerPiece& piece, double steps) {
  throw Error(Error::Kind::bad_input,
              say("{} = {:.9g}{}{} does not fit the format of the controller", Name{key_of(piece)},
                  steps * piece.factor, piece.unit.text() == "1" ? "" : " ", Name{piece.unit.text()}));
}

std::string write_binary(const ControllerPiece& piece, double steps) {
  const int bits = 8 * piece.bytes;
  std::uint64_t raw = 0;
  if (piece.is_real) {
    raw = std::bit_cast<std::uint32_t>(static_cast<float>(steps));
    if (!std::isfinite(static_cast<float>(steps))) does_not_fit(piece, steps);
  } else {
    const double whole = std::nearbyint(steps);
    const double least = piece.is_signed ? -std::ldexp(1.0, bits - 1) : 0.0;
    const double most = std::ldexp(1.0, piece.is_signed ? bits - 1 : bits) - 1.0;
    if (!(whole >= least && whole <= most)) does_not_fit(piece, steps);
    raw = static_cast<std::uint64_t>(static_cast<std::int64_t>(whole));
  }
  std::string bytes;
  for (int i = 0; i < piece.bytes; ++i)
    bytes += static_cast<char>(raw >> (8 * (piece.big ? piece.bytes - 1 - i : i)) & 0xffu);
  return bytes;
}

std::optional<double> take_binary(const ControllerPiece& piece, std::string_view& bytes) {
  const auto size = static_cast<std::size_t>(piece.bytes);
  if (bytes.size() < size) return std::nullopt;
  std::uint64_t raw = 0;
  for (std::size_t i = 0; i < size; ++i)
    raw |= std::uint64_t{static_cast<unsigned char>(bytes[i])} << (8 * (piece.big ? size - 1 - i : i));
  bytes.remove_prefix(size);
  if (piece.is_real) {
    const double value = std::bit_cast<float>(static_cast<std::uint32_t>(raw));
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
  }
  const int unused = 64 - 8 * piece.bytes;
  return piece.is_signed ? static_cast<double>(static_cast<std::int64_t>(raw << unused) >> unused)
                         : static_cast<double>(raw);
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

std::string decimal(const ControllerPiece& piece, double steps) {
  std::string text;
  const int width = piece.width;
  if (piece.type == 'd' || piece.type == 'X') {
    const double whole = std::nearbyint(steps);
    if (!(std::abs(whole) <= 9e15) || (piece.type == 'X' && whole < 0.0)) does_not_fit(piece, steps);
    const auto number = static_cast<long long>(whole);
    if (piece.type == 'X')
      return piece.zeros ? fmt::format("{:0{}X}", number, width) : fmt::format("{:{}X}", number, width);
    text = piece.plus ? fmt::format("{:+}", number) : fmt::format("{}", number);
  } else {
    const std::string form = fmt::format("{{:{}.{}{}}}", piece.plus ? "+" : "", piece.precision, piece.type);
    text = fmt::format(fmt::runtime(form), steps);
    if (text[0] == '-' && text.find_first_of("123456789") == text.npos)  // a zero has no sign
      text = fmt::format(fmt::runtime(form), 0.0);
  }
  const auto missing = static_cast<std::size_t>(std::max(0, width - static_cast<int>(text.size())));
  const bool has_sign = text[0] == '-' || text[0] == '+';
  if (piece.zeros) return text.insert(has_sign ? 1 : 0, missing, '0');
  return std::string(missing, ' ') + text;
}

}  // namespace

std::string write_number(const ControllerPiece& piece, double si) {
  const double steps = piece.unit.from_si(si) / piece.factor;
  if (!std::isfinite(steps) || std::abs(steps) > 1e30) does_not_fit(piece, steps);
  if (piece.part == ControllerPiece::Part::sign) return steps < 0.0 ? "-" : "";
  const double written = piece.part == ControllerPiece::Part::magnitude ? std::abs(steps) : steps;
  if (piece.bytes > 0) return write_binary(piece, written);
  std::string text = decimal(piece, written);
  if (piece.zeros && text.size() != static_cast<std::size_t>(piece.width)) does_not_fit(piece, steps);
  return text;
}

std::optional<double> take_number(const ControllerPiece& piece, std::string_view& bytes) {
  std::optional<double> steps;
  if (piece.part == ControllerPiece::Part::sign) {
    const bool minus = bytes.starts_with('-');
    if (minus || bytes.starts_with('+')) bytes.remove_prefix(1);
    return minus ? -1.0 : 1.0;
  }
  if (piece.bytes > 0) {
    steps = take_binary(piece, bytes);
  } else {
    if (!piece.zeros)
      while (bytes.starts_with(' ')) bytes.remove_prefix(1);
    auto text = piece.zeros ? bytes.substr(0, static_cast<std::size_t>(piece.width)) : bytes;
    const bool hex = piece.type == 'X';
    text = text.substr(0, hex ? length_of_hex(text) : length_of_decimal(text));
    const bool fits = !piece.zeros || (text.size() == static_cast<std::size_t>(piece.width) &&
                                       (hex || has_decimals(text, piece.precision)));
    if (text.empty() || !fits || (piece.type == 'd' && text.find_first_of(".eE") != text.npos)) return std::nullopt;
    bytes.remove_prefix(text.size());
    if (hex && text.size() <= 12)
      steps = static_cast<double>(std::strtoull(std::string(text).c_str(), nullptr, 16));
    else if (!hex)
      steps = parse_decimal(text);
  }
  if (!steps || (piece.part == ControllerPiece::Part::magnitude && *steps < 0.0)) return std::nullopt;
  const double si = piece.unit.to_si(*steps * piece.factor);
  return std::isfinite(si) ? std::optional(si) : std::nullopt;
}

double resolution(const ControllerPiece& piece, double si) {
  const double step = std::abs(piece.unit.factor() * piece.factor);
  const double steps = std::abs(piece.unit.from_si(si) / piece.factor);
  double half = 0.5;
  if (piece.is_real)
    half = std::ldexp(steps, -24);
  else if (piece.bytes == 0 && piece.type == 'f')
    half = 0.5 * std::pow(10.0, -piece.precision);
  else if (piece.bytes == 0 && (piece.type == 'e' || piece.type == 'g'))
    half = 0.5 * steps * std::pow(10.0, piece.type == 'e' ? -piece.precision : 1 - std::max(piece.precision, 1));
  return step * (half + 4e-16 * steps) + 4e-16 * std::abs(si);
}

double value_of_default(const ControllerPiece& piece) {
  const auto steps = parse_decimal(piece.otherwise.value_or("0"));
  if (!steps) throw Error(Error::Kind::bad_input, say("'{}' is not a number", *piece.otherwise));
  return piece.unit.to_si(*steps * piece.factor);
}

}  // namespace tumble::controller
