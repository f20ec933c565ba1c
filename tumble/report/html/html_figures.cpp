#include <fmt/format.h>

#include "tumble/report/figure.hpp"
#include "tumble/report/html/html.hpp"

namespace tumble::html {
namespace {

std::string caption(const Figure& figure, std::size_t number, const Words& words) {
  std::string text = fmt::format("<b>{}.</b> {}.", words.with("figure", std::to_string(number)), escaped(figure.name));
  for (const auto& series : figure.series)
    if (!series.lower.empty() && !series.band.empty())
      text += " " + words.with(series.points ? "bars_of" : "band_of", escaped(series.name), escaped(series.band));
  for (const auto& note : figure.notes) text += " " + escaped(note) + ".";
  return text;
}

}  // namespace

std::string figures(const Estimate& estimate, const Words& words) {
  const auto all = figures_of(estimate);
  if (all.empty()) return {};
  std::string section = "<section id=\"figures\">\n<h2>" + words("figures") + "</h2>\n";
  for (std::size_t i = 0; i < all.size(); ++i)
    section += fmt::format("<figure id=\"figure-{0}\">\n{1}<figcaption>{2}</figcaption>\n</figure>\n", i + 1,
                           to_svg(all[i]), caption(all[i], i + 1, words));
  return section + "</section>\n";
}

}  // namespace tumble::html
