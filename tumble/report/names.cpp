#include "tumble/report/names.hpp"

#include <algorithm>

#include "tumble/language/said.hpp"
#include "tumble/language/texts.hpp"

namespace tumble {
namespace {

bool is_small(char c) { return c >= 'a' && c <= 'z'; }

/// Whether three small letters or more stand next to each other.
bool has_word(std::string_view name) {
  int length = 0;
  for (const char c : name) {
    length = is_small(c) ? length + 1 : 0;
    if (length == 3) return true;
  }
  return false;
}

/// "gyro.x.angle_random_walk": the point before the quantity becomes a blank, that of the channel stays.
void separate_quantity(std::string& text) {
  const auto point = text.rfind('.');
  if (point == std::string::npos || point == 0) return;
  const auto quantity = std::string_view(text).substr(point + 1);
  const bool behind_channel = text.find('.') < point || quantity.find('_') != std::string_view::npos;
  if (behind_channel && quantity.find(' ') == std::string_view::npos && has_word(quantity)) text[point] = ' ';
}

}  // namespace

std::string readable_name(std::string_view name) {
  std::string text(name);
  separate_quantity(text);
  for (std::size_t begin = 0; begin < text.size();) {
    const auto end = std::min(text.find(' ', begin), text.size());
    if (has_word(std::string_view(text).substr(begin, end - begin)))
      std::replace(text.begin() + static_cast<std::ptrdiff_t>(begin), text.begin() + static_cast<std::ptrdiff_t>(end),
                   '_', ' ');
    begin = end + 1;
  }
  return text;
}

std::string readable_name(Language language, std::string_view name, std::string_view method) {
  if (language == Language::english) return readable_name(name);
  if (!method.empty())
    if (auto text = find_text(language, "result", std::string(method) + " " + std::string(name))) return *text;
  return result_words_in(language, name).value_or(readable_name(name));
}

}  // namespace tumble
