#include "tumble/units/text_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tumble {
namespace {

constexpr std::string_view blanks = " \t\r\n";

}  // namespace

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(blanks);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

bool is_blank(std::string_view text) { return trimmed(text).empty(); }

bool is_digits(std::string_view text) { return !text.empty() && text.find_first_not_of("0123456789") == text.npos; }

bool is_hex(std::string_view text) { return text.find_first_not_of("0123456789abcdef") == text.npos; }

std::string first_digits(std::string_view identifier, std::size_t count) {
  return std::string(identifier.substr(0, count));
}

std::vector<std::string> list_items(std::string_view list, char separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= list.size();) {
    const auto end = std::min(list.find(separator, begin), list.size());
    parts.emplace_back(trimmed(list.substr(begin, end - begin)));
    begin = end + 1;
  }
  return parts;
}

std::optional<std::pair<std::string, std::string>> key_and_value(std::string_view text, char mark) {
  const auto place = text.find(mark);
  if (place == text.npos) return std::nullopt;
  return std::pair(std::string(text.substr(0, place)), std::string(text.substr(place + 1)));
}

double rounded_to_digits(double value, int digits) {
  if (!std::isfinite(value)) return value;
  return as_number<double>(fmt::format("{:.{}e}", value, digits - 1)).value_or(value);
}

}  // namespace tumble
