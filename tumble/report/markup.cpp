#include "tumble/report/markup.hpp"

#include "tumble/report/utf8.hpp"

namespace tumble {

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : printable(text)) {
    switch (c) {
      case '&':
        result += "&#38;";
        break;
      case '<':
        result += "&#60;";
        break;
      case '>':
        result += "&#62;";
        break;
      case '"':
        result += "&#34;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

const std::vector<std::string>& palette() {
  // Okabe and Ito (2008), without their yellow and black, in an order of alternating lightness.
  static const std::vector<std::string> colours{"#0072b2", "#e69f00", "#009e73", "#d55e00", "#56b4e9", "#cc79a7"};
  return colours;
}

const std::vector<std::string>& palette_on_dark() {
  static const std::vector<std::string> colours{"#4aa8e0", "#f0b429", "#2fc19a", "#f08a4b", "#8fd0f5", "#e09cc4"};
  return colours;
}

}  // namespace tumble
