#include <fmt/format.h>

#include <algorithm>

#include "tumble/report/figure.hpp"
#include "tumble/report/html/html.hpp"

namespace tumble::html {
namespace {

// So many points together keep a page below 300 kB; a series has enough of them for each hundredth of its width.
constexpr std::size_t most_points = 9000, most_of_series = 4000, least_of_series = 300;

std::size_t points_for(const std::vector<Figure>& figures) {
  std::size_t series = 1;
  for (const auto& figure : figures) series += figure.series.size();
  return std::clamp(most_points / series, least_of_series, most_of_series);
}

std::string caption(const Figure& figure, std::size_t number, bool fewer, const Words& words) {
  const std::string gap = words.language == Language::chinese ? "" : " ";  // between two sentences
  auto text = words.with("figure_caption", words.with("figure", std::to_string(number)), escaped(figure.name));
  for (const auto& series : figure.series)
    if (!series.lower.empty() && !series.band.empty())
      text += gap + words.with(series.points ? "bars_of" : "band_of", escaped(series.name), escaped(series.band));
  for (const auto& note : figure.notes) text += words.with("figure_note", escaped(note));
  if (fewer) text += gap + words("fewer_points");
  return text;
}

/// The drawing for a page and for paper, and the narrow one of the same figure for a phone.
std::string figure_html(const Figure& figure, std::size_t number, std::size_t most, const Words& words) {
  const bool fewer = std::ranges::any_of(figure.series, [&](const auto& s) { return s.points && s.x.size() > most; });
  return fmt::format(
      "<figure id=\"figure-{}\">\n<div class=\"for-page\">{}</div>\n<div class=\"for-phone\">{}</div>\n"
      "<figcaption>{}</figcaption>\n</figure>\n",
      number, to_svg(with_fewer_points(figure, most)), to_svg(with_fewer_points(figure, most / 2), Drawing::phone),
      caption(figure, number, fewer, words));
}

}  // namespace

std::string first_figure(const std::vector<Figure>& figures, const Words& words) {
  if (figures.empty()) return {};
  return "<section id=\"figure\">\n" + figure_html(figures.front(), 1, points_for(figures), words) + "</section>\n";
}

std::string further_figures(const std::vector<Figure>& figures, const Words& words) {
  if (figures.size() < 2) return {};
  std::string section = "<section id=\"figures\">\n<h2>" + words("figures") + "</h2>\n";
  for (std::size_t i = 1; i < figures.size(); ++i)
    section += figure_html(figures[i], i + 1, points_for(figures), words);
  return section + "</section>\n";
}

}  // namespace tumble::html
