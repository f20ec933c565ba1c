#include <fmt/format.h>

#include "tumble/report/html/html.hpp"
#include "tumble/report/utf8.hpp"
#include "tumble/version.hpp"

namespace tumble::assets {
extern const std::string_view report_css;
}

namespace tumble::html {
namespace {

/// A string of CSS: nothing in it ends the string, or the element in which the style stands.
std::string css_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : printable(text)) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == ' ' ||
                       static_cast<unsigned char>(c) >= 0x80;
    result += plain ? std::string(1, c) : fmt::format("\\{:x} ", static_cast<int>(c));
  }
  return result + "\"";
}

/// Bars of the budget, and the drawings on a dark page: their colours are attributes, over which a style goes.
std::string colours() {
  const auto &light = palette(), &dark = palette_on_dark();
  std::string text, on_dark;
  for (std::size_t i = 0; i < light.size(); ++i) {
    text += fmt::format(".s{} {{ background: {}; color: {}; }}\n", i, light[i], i == 0 ? "#fff" : "#000");
    on_dark += fmt::format(
        ".s{0} {{ background: {2}; color: #000; }}\nfigure [stroke=\"{1}\"] {{ stroke: {2}; }}\n"
        "figure [fill=\"{1}\"] {{ fill: {2}; }}\n",
        i, light[i], dark[i]);
  }
  return text + "@media screen and (prefers-color-scheme: dark) {\n" + on_dark + "}\n";
}

/// The beginning of a long title, as much as stands beside a serial number.
std::string short_title(std::string_view title) {
  constexpr std::size_t most = 64;
  const auto text = printable(title);
  if (display_width(text) <= most) return text;
  std::string result;
  for (const char c : text) {
    const bool starts_character = (static_cast<unsigned char>(c) & 0xC0) != 0x80;
    if (starts_character && display_width(result) >= most - 1) break;
    result += c;
  }
  return result + "…";
}

/// Running head and page numbers of paper.
std::string paper(const std::string& title, const std::string& serial) {
  return fmt::format(
      "@page {{\n  @top-left {{ content: {}; }}\n  @top-right {{ content: {}; }}\n"
      "  @bottom-left {{ content: {}; }}\n  @bottom-right {{ content: counter(page) \" / \" counter(pages); }}\n}}\n",
      css_string(short_title(title)), css_string(short_title(serial)), css_string(fmt::format("Tumble {}", version)));
}

}  // namespace

std::string style(const std::string& title, const std::string& serial) {
  return std::string(assets::report_css) + colours() + paper(title, serial);
}

}  // namespace tumble::html
