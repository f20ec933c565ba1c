#include "tumble/report/typeset.hpp"

#include <charconv>

#include "tumble/report/figure/ticks.hpp"
#include "tumble/report/html/html.hpp"

namespace tumble {

std::string typeset_number(std::string_view text) { return html::number(text); }

std::string number_in_characters(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    int exponent = 0;
    const bool behind_number =
        i > 0 && (text[i - 1] == ')' || text[i - 1] == ']' || (text[i - 1] >= '0' && text[i - 1] <= '9'));
    const auto read = std::from_chars(text.data() + i + 1, text.data() + text.size(), exponent);
    if (text[i] == 'e' && behind_number && read.ec == std::errc{}) {
      result += " × " + figure::power_of_ten(exponent);
      i = static_cast<std::size_t>(read.ptr - text.data()) - 1;
    } else {
      result += text[i] == '-' ? std::string("−") : std::string(1, text[i]);
    }
  }
  return result;
}

std::string typeset_unit(const Unit& unit) { return html::unit(unit); }

std::string typeset_symbol(std::string_view text) { return html::symbol(text); }

}  // namespace tumble
