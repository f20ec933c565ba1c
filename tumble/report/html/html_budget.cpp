#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tumble/report/html/html.hpp"
#include "tumble/report/names.hpp"
#include "tumble/report/rounding.hpp"

namespace tumble::html {
namespace {

/// So many sources fit beside each other on a sheet; of more, each parameter lists those that matter to it.
constexpr std::size_t most_columns = 4;

std::string head_of_table(const Words& words) {
  return fmt::format(
      "<div class=\"wide\" tabindex=\"0\"><table class=\"sources\">\n<caption>{}</caption>\n<thead><tr><th "
      "scope=\"col\">{}</th>"
      "<th scope=\"col\">{}</th><th scope=\"col\" class=\"n\">{}</th>",
      words("budget_caption"), words("parameter"), words("unit"), words("together"));
}

std::string head_of_row(const Estimate& estimate, std::size_t i, const Words& words) {
  const double sd = shown(estimate, i).sd;
  return fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td><td class=\"n\"><b>{}</b></td>",
                     escaped(readable_name(words.language, estimate.parameters[i].name, estimate.method)),
                     unit(estimate.parameters[i].unit), number(rounded(sd, rounding_for(0.0, sd))));
}

/// A column for each source.
std::string table_of_columns(const Estimate& estimate, const Words& words) {
  std::string text = head_of_table(words);
  for (const auto& part : estimate.budget)
    text += fmt::format("<th scope=\"colgroup\" colspan=\"2\" class=\"n\">{}</th>", escaped(part.source));
  text += "</tr></thead>\n<tbody>\n";
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    text += head_of_row(estimate, i, words);
    for (const auto& part : estimate.budget) {
      const auto [sd, share] = budget_cell(estimate, part, i, words.language);
      text += fmt::format("<td class=\"n\">{}</td><td class=\"n share\">{}</td>", number(sd), escaped(share));
    }
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

/// The sources of a parameter that give 1 % of its variance and more, the largest first: "output noise 0.012 (43 %),
/// ..."
std::string sources_of(const Estimate& estimate, std::size_t i, const Words& words) {
  std::vector<const Contribution*> parts;
  for (const auto& part : estimate.budget)
    if (part.variance(i) >= 0.01 * estimate.covariance(i, i)) parts.push_back(&part);
  std::ranges::stable_sort(parts, std::greater<>(), [&](const auto* part) { return part->variance(i); });
  std::string text;
  for (const auto* part : parts) {
    const auto [sd, share] = budget_cell(estimate, *part, i, words.language);
    text += (text.empty() ? "" : words("next_source")) +
            words.with("source_part", escaped(part->source), number(sd), escaped(share));
  }
  return text;
}

std::string table_of_lists(const Estimate& estimate, const Words& words) {
  std::string text = head_of_table(words) + "<th scope=\"col\">" + words("sources") + "</th></tr></thead>\n<tbody>\n";
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i)
    text += head_of_row(estimate, i, words) + "<td class=\"sources-list\">" + sources_of(estimate, i, words) +
            "</td></tr>\n";
  return text + "</tbody></table></div>\n";
}

/// Sources beyond the colours of the palette are distinguished by stripes over the colour.
std::string class_of(std::size_t source) {
  return fmt::format("s{}{}", source % palette().size(), source >= palette().size() ? " striped" : "");
}

std::string legend(const Estimate& estimate) {
  std::string text = "<ul class=\"legend\">";
  for (std::size_t k = 0; k < estimate.budget.size(); ++k)
    text +=
        fmt::format("<li><span class=\"swatch {}\"></span>{}</li>", class_of(k), escaped(estimate.budget[k].source));
  return text + "</ul>\n";
}

std::string bar(const Estimate& estimate, std::size_t i, const Words& words) {
  const auto& parameter = estimate.parameters[i];
  const double whole = estimate.covariance(i, i);
  std::string text = fmt::format("<div class=\"bar-row\"><span class=\"bar-name\">{}</span><span class=\"bar\">",
                                 escaped(readable_name(words.language, parameter.name, estimate.method)));
  for (std::size_t k = 0; k < estimate.budget.size(); ++k) {
    const double share = estimate.budget[k].variance(i) / whole;
    if (!(share > 0.001) || !std::isfinite(share)) continue;
    const auto percent = escaped(budget_cell(estimate, estimate.budget[k], i, words.language).share);
    text += fmt::format("<span class=\"{}\" style=\"width:{:.1f}%\" title=\"{}: {}\">{}</span>", class_of(k),
                        100.0 * std::min(share, 1.0), escaped(estimate.budget[k].source), percent,
                        share > 0.09 ? percent : "");
  }
  return text + "</span></div>\n";
}

std::string bars(const Estimate& estimate, const Words& words) {
  std::string text =
      fmt::format("<figure class=\"bars\" role=\"img\" aria-label=\"{}\">\n{}", words("bars_label"), legend(estimate));
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) text += bar(estimate, i, words);
  return text + "<figcaption>" + words("bars_caption") + "</figcaption>\n</figure>\n";
}

}  // namespace

std::string budget(const Estimate& estimate, const Words& words) {
  if (estimate.budget.empty() || estimate.parameters.empty()) return {};
  Estimate shown;
  shown.method = estimate.method;
  shown.parameters = estimate.parameters;
  shown.covariance = estimate.covariance;
  shown.budget = budget_to_show(estimate, words.language);
  return "<section id=\"budget\">\n<h2>" + words("budget") + "</h2>\n" + bars(shown, words) +
         (shown.budget.size() <= most_columns ? table_of_columns(shown, words) : table_of_lists(shown, words)) +
         "</section>\n";
}

}  // namespace tumble::html
