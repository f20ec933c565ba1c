#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/report/html/html.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/report/utf8.hpp"

namespace tumble::html {
namespace {

// The bar figure, in its own units (the page scales it).
constexpr double label_width = 230, bar_width = 700, bar_height = 20, row_height = 28, legend_row = 22;

std::string table(const Estimate& estimate, const Words& words) {
  std::string text = fmt::format(
      "<div class=\"wide\"><table class=\"sources\">\n<caption>{}</caption>\n<thead><tr><th scope=\"col\">{}</th>"
      "<th scope=\"col\">{}</th>",
      words("budget_caption"), words("parameter"), words("unit"));
  for (const auto& part : estimate.budget) {
    text += fmt::format("<th scope=\"colgroup\" colspan=\"2\" class=\"n\">{}</th>", escaped(part.source));
  }
  text += "<th scope=\"col\" class=\"n\">" + words("together") + "</th></tr></thead>\n<tbody>\n";
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const auto& parameter = estimate.parameters[i];
    text += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td>", escaped(parameter.name), unit(parameter.unit));
    for (const auto& part : estimate.budget) {
      const auto [sd, share] = budget_cell(estimate, part, i);
      text += fmt::format("<td class=\"n\">{}</td><td class=\"n share\">{}</td>", number(sd), escaped(share));
    }
    const double sd = shown(estimate, i).sd;
    text += fmt::format("<td class=\"n\"><b>{}</b></td></tr>\n", number(rounded(sd, rounding_for(0.0, sd))));
  }
  return text + "</tbody></table></div>\n";
}

std::string shortened(std::string_view name) {
  const auto text = printable(name);
  if (display_width(text) <= 32) return escaped(text);
  std::string result;
  for (const char c : text) {
    const bool starts_character = (static_cast<unsigned char>(c) & 0xC0) != 0x80;
    if (starts_character && display_width(result) >= 30) break;
    result += c;
  }
  return escaped(result) + "…";
}

const std::string& colour(std::size_t source) { return palette()[source % palette().size()]; }

/// Sources beyond the colours of the palette are told apart by stripes over the colour.
std::string segment(double x, double y, double width, std::size_t source, const std::string& tip) {
  const auto at = fmt::format("x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.0f}\"", x, y, width, bar_height);
  std::string text =
      fmt::format("<rect {} fill=\"{}\" stroke=\"#fff\"><title>{}</title></rect>", at, colour(source), tip);
  if (source >= palette().size()) text += fmt::format("<rect {} fill=\"url(#stripes)\" pointer-events=\"none\"/>", at);
  return text;
}

std::string bar(const Estimate& estimate, std::size_t i, double y) {
  const auto& parameter = estimate.parameters[i];
  std::string text = fmt::format("<text x=\"{:.0f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>", label_width - 10,
                                 y + 15, shortened(parameter.name));
  const double whole = estimate.covariance(i, i);
  double x = label_width;
  for (std::size_t k = 0; k < estimate.budget.size(); ++k) {
    const double share = estimate.budget[k].variance(i) / whole;
    if (!(share > 0.0) || !std::isfinite(share)) continue;
    const double width = std::min(share * bar_width, label_width + bar_width - x);
    const auto percent = budget_cell(estimate, estimate.budget[k], i).share;
    const auto tip = fmt::format("{}, {}: {}", escaped(parameter.name), escaped(estimate.budget[k].source), percent);
    text += segment(x, y, std::max(0.0, width), k, tip);
    if (share > 0.07) {
      text += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\" class=\"on-bar c{}\">{}</text>",
                          x + width / 2, y + 15, k % palette().size(), percent);
    }
    x += width;
  }
  return text + "\n";
}

std::string legend(const Estimate& estimate, double& height) {
  std::string text;
  double x = label_width, y = 0;
  for (std::size_t k = 0; k < estimate.budget.size(); ++k) {
    const auto name = escaped(estimate.budget[k].source);
    const double width = 40.0 + 7.6 * static_cast<double>(display_width(printable(estimate.budget[k].source)));
    if (x + width > label_width + bar_width && x > label_width) {
      x = label_width;
      y += legend_row;
    }
    text +=
        segment(x, y, 18, k, name) + fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x + 24, y + 15, name);
    x += width;
  }
  height = y + legend_row + 8;
  return text;
}

std::string bars(const Estimate& estimate, const Words& words) {
  double top = 0;
  const auto key = legend(estimate, top);
  const double height = top + row_height * static_cast<double>(estimate.parameters.size());
  std::string text = fmt::format(
      "<figure class=\"bars\">\n<svg viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\">\n<defs><pattern "
      "id=\"stripes\" width=\"6\" "
      "height=\"6\" patternUnits=\"userSpaceOnUse\" patternTransform=\"rotate(45)\"><rect width=\"2\" height=\"6\" "
      "fill=\"#fff\" fill-opacity=\"0.7\"/></pattern></defs>\n",
      label_width + bar_width + 2, height, words("bars_label"));
  text += key;
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    text += bar(estimate, i, top + row_height * static_cast<double>(i));
  }
  return text + "</svg>\n<figcaption>" + words("bars_caption") + "</figcaption>\n</figure>\n";
}

}  // namespace

std::string budget(const Estimate& estimate, const Words& words) {
  if (estimate.budget.empty() || estimate.parameters.empty()) return {};
  Estimate shown;
  shown.parameters = estimate.parameters;
  shown.covariance = estimate.covariance;
  shown.budget = budget_to_show(estimate);
  return "<section id=\"budget\">\n<h2>" + words("budget") + "</h2>\n" + table(shown, words) + bars(shown, words) +
         "</section>\n";
}

}  // namespace tumble::html
