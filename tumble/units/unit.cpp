#include "tumble/units/unit.hpp"

#include <charconv>
#include <cmath>
#include <string>

#include "tumble/units/error.hpp"

namespace tumble {

namespace {

constexpr std::string_view base_names[Dimension::bases] = {"m", "kg", "s", "A", "K", "rad", "count"};

std::string half_power(std::string_view base, int halves) {
  std::string text(base);
  if (halves == 2) return text;
  text += "^" + std::to_string(halves / 2);
  return halves % 2 == 0 ? text : text + ".5";
}

bool blank(char c) { return c == ' ' || c == '\t'; }

std::string digits(double value, int precision) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, precision).ptr;
  return {text, end};
}

/// Whether the decimal converts to exactly `value_si`.
bool returns(const std::string& decimal, double value_si, const Unit& unit) {
  double read = 0.0;
  std::from_chars(decimal.data(), decimal.data() + decimal.size(), read);
  return unit.to_si(read) == value_si;
}

/// `value` with as few digits as return `value_si`; empty when 17 do not.
std::string shortest(double value, double value_si, const Unit& unit) {
  // Without an offset, 15 digits say it whenever any decimal of up to 15 digits was the source, and trailing zeros are
  // not written; with one, the sum has lost digits and fewer may do.
  const int first = unit.offset() == 0.0 ? 15 : 1;
  for (int precision = first; precision <= 17; ++precision) {
    std::string text = digits(value, precision);
    if (!returns(text, value_si, unit)) continue;
    if (precision >= 15) return text;
    double read = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), read);
    return digits(read, 15);  // the same number, but 20 rather than 2e+01
  }
  return "";
}

[[noreturn]] void refuse(Sentence problem) { throw Error(Error::Kind::bad_input, std::move(problem)); }

}  // namespace

std::string name(const Dimension& dimension) {
  std::string above, below;
  int divisors = 0;
  for (int i = 0; i < Dimension::bases; ++i) {
    const int halves = dimension.halves[i];  // NOLINT(bugprone-signed-char-misuse): a small number
    if (halves == 0) continue;
    std::string& part = halves > 0 ? above : below;
    if (!part.empty()) part += "*";
    part += half_power(base_names[i], std::abs(halves));
    divisors += halves < 0;
  }
  if (above.empty()) above = "1";
  if (below.empty()) return above;
  return above + "/" + (divisors > 1 ? "(" + below + ")" : below);
}

Quantity parse_quantity(std::string_view text) {
  const std::string_view whole = text;
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  Quantity quantity;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), quantity.value);
  const Name shown{std::string(whole)};
  if (problem == std::errc::result_out_of_range) refuse(say("'{}': the number is out of range", shown));
  if (problem != std::errc{} || !std::isfinite(quantity.value))
    refuse(say("'{}': a number with a unit expected, for example '1.5 deg/h'", shown));
  std::string_view rest = text.substr(static_cast<std::size_t>(end - text.data()));
  if (rest.starts_with(',')) refuse(say("'{}': write a decimal point, not a comma", shown));
  while (!rest.empty() && blank(rest.front())) rest.remove_prefix(1);
  quantity.bare = rest.empty();
  if (!quantity.bare) quantity.unit = Unit::parse(rest);
  return quantity;
}

double parse_si(std::string_view text, const Unit& expected) {
  const Quantity quantity = parse_quantity(text);
  if (quantity.bare && expected.dimension() == Dimension{} && expected.factor() == 1.0) return quantity.value;
  const Name shown{std::string(text)};
  if (quantity.bare)
    refuse(say("'{}' has no unit: write for example '{} {}'", shown, Name{digits(quantity.value, 15)},
               Name{expected.text()}));
  if (quantity.unit.dimension() != expected.dimension())
    refuse(say("'{}' is in {}, but a quantity in {} ({}) is expected", shown, Name{name(quantity.unit.dimension())},
               Name{expected.text()}, Name{name(expected.dimension())}));
  return expected.offset() != 0.0 ? quantity.unit.to_si(quantity.value)
                                  : quantity.unit.difference_to_si(quantity.value);
}

std::string format_in(double value_si, const Unit& unit) {
  const double value = unit.from_si(value_si);
  if (!std::isfinite(value)) return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
  std::string text = shortest(value, value_si, unit);
  if (text.empty()) text = shortest(std::nextafter(value, INFINITY), value_si, unit);
  if (text.empty()) text = shortest(std::nextafter(value, -INFINITY), value_si, unit);
  return text.empty() ? digits(value, 17) : text;  // some numbers are not the product of any double and the factor
}

double si(double value, std::string_view unit) { return Unit::parse(unit).to_si(value); }

}  // namespace tumble
