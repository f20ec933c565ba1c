#include <fmt/format.h>

#include <algorithm>

#include "tumble/report/html/html.hpp"
#include "tumble/report/names.hpp"

namespace tumble::html {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Length of an exponent such as "-5", "2", "1.5" or "(1/2)" at the start of the text.
std::size_t exponent_length(std::string_view text) {
  if (text.starts_with('(')) {
    const auto end = text.find(')');
    return end == std::string_view::npos ? 0 : end + 1;
  }
  std::size_t length = text.starts_with('-') ? 1 : 0;
  while (length < text.size() && (is_digit(text[length]) || text[length] == '.')) ++length;
  return length;
}

}  // namespace

std::string number(std::string_view text) {
  const auto raise = [](std::string_view exponent) { return "\u202F×\u202F10<sup>" + number(exponent) + "</sup>"; };
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char before = i == 0 ? ' ' : text[i - 1];
    const bool exponent = text[i] == 'e' && (is_digit(before) || before == ')' || before == ']');
    const auto length = exponent ? exponent_length(text.substr(i + 1)) : 0;
    if (length > 0) {
      result += raise(text.substr(i + 1, length));
      i += length;
    } else {
      result += text[i] == '-' ? std::string("−") : std::string(1, text[i]);
    }
  }
  return result;
}

std::string unit(const Unit& unit) {
  std::string_view rest = unit.text();
  if (rest == "1") return {};
  std::string result;
  while (!rest.empty()) {
    const auto power = std::min(rest.find('^'), rest.size());
    result += escaped(rest.substr(0, power));
    rest.remove_prefix(power);
    if (rest.empty()) break;
    const auto length = exponent_length(rest.substr(1));
    result += length == 0 ? "^" : "<sup>" + escaped(rest.substr(1, length)) + "</sup>";
    rest.remove_prefix(1 + length);
  }
  return result;
}

std::string symbol(std::string_view text) {
  const auto split = text.find('_');
  if (split == std::string_view::npos || split == 0) return "<var>" + escaped(text) + "</var>";
  return "<var>" + escaped(text.substr(0, split)) + "</var><sub>" + escaped(text.substr(split + 1)) + "</sub>";
}

std::string name_html(std::string_view name, const Words& words, std::string_view method) {
  const auto readable = readable_name(words.language, name, method);
  if (readable == name) return escaped(name);
  return escaped(readable) + " <code>" + escaped(name) + "</code>";
}

}  // namespace tumble::html
