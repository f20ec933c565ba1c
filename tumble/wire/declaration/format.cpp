#include "tumble/wire/declaration/format.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace tumble::declaration {

std::optional<int> take_whole(std::string_view& text, int most) {
  int value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || value < 0 || value > most) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

std::optional<FrameFormat> take_format(std::string_view& text, int most) {
  FrameFormat format;
  const auto take = [&](char c) {
    const bool found = text.starts_with(c);
    if (found) text.remove_prefix(1);
    return found;
  };
  format.plus = take('+');
  format.zeros = take('0');
  if (!text.empty() && text.front() >= '0' && text.front() <= '9') {
    const auto width = take_whole(text, most);
    if (!width) return std::nullopt;
    format.width = *width;
  }
  if (!take('.')) return format;
  const auto decimals = take_whole(text, most);
  if (!decimals) return std::nullopt;
  format.decimals = *decimals;
  return format;
}

double half_of_last_digit(const std::string& text) {
  const auto end = std::min(text.find_first_not_of("+-0123456789.eE"), text.size());
  const auto mark = std::min(text.find_first_of("eE"), end), point = text.find('.');
  const double decimals = point < mark ? static_cast<double>(mark - point) - 1.0 : 0.0;
  const double exponent = mark + 1 < end ? std::strtod(text.c_str() + mark + 1, nullptr) : 0.0;
  return 0.5 * std::pow(10.0, std::clamp(exponent, -300.0, 300.0) - decimals);
}

}  // namespace tumble::declaration
