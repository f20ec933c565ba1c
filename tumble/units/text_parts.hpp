#pragma once

#include <charconv>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// Parts of texts that people write: values of options and settings, identifiers.
namespace tumble {

/// The texts [N] in their order, with `between` between each two: "gyro_x, gyro_y". Empty without texts.
std::string joined(std::span<const std::string> texts, std::string_view between = ", ");

/// The part of the text without the blanks at its two ends. It points into `text`.
///
/// Given     blanks  the letters that count as blank
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t\r\n");
/// Whether nothing but blanks, tabs and line ends is in it.
bool is_blank(std::string_view text);
/// Whether it consists of digits 0 to 9 alone, at least one.
bool is_digits(std::string_view text);
/// Whether it consists of hexadecimal digits alone, in lower case. A text of no character does.
bool is_hex(std::string_view text);

/// The first characters of an identifier, `count` [1] of them: hashes are shown by their first 12 digits.
std::string first_digits(std::string_view identifier, std::size_t count = 12);

/// The parts of a list between separators, each trimmed. A text of no character has one part, which is empty.
std::vector<std::string> list_items(std::string_view list, char separator = ',');

/// Texts before and behind the first `mark`: "KEY=VALUE". Absent: the text has none.
std::optional<std::pair<std::string, std::string>> key_and_value(std::string_view text, char mark = '=');

/// The text as a whole number, or as a decimal; absent for other texts, also with anything beside it or out of range.
template <class Number>
std::optional<Number> as_number(std::string_view text) {
  Number value{};
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// The value [u] rounded to so many significant decimal digits [1].
double rounded_to_digits(double value, int digits);

}  // namespace tumble
