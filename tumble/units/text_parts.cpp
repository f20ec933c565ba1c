#include "tumble/units/text_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tumble {

std::string joined(std::span<const std::string> texts, std::string_view between) {
  std::string all;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    if (i > 0) all += between;
    all += texts[i];
  }
  return all;
}

std::string_view trimmed(std::string_view text, std::string_view blanks) {
  const auto begin = text.find_first_not_of(blanks);
  if (begin == std::string_view::npos) return text.substr(text.size());
  return text.substr(begin, text.find_last_not_of(blanks) + 1 - begin);
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
