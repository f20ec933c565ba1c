#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/language/said.hpp"
#include "tumble/report/html/html.hpp"
#include "tumble/report/parameter_rows.hpp"
#include "tumble/report/utf8.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::html {
namespace {

/// Widths that the parts of the numbers of a column have at least: the points stand below each other in any font.
struct Widths {
  std::size_t value = 0, sd_before = 0, lower = 0, upper_before = 0;  ///< [characters]

  explicit Widths(const std::vector<ParameterRow>& rows) {
    const auto widen = [](std::size_t& width, const std::string& text) {
      width = std::max(width, display_width(text));
    };
    for (const auto& row : rows) {
      widen(value, row.value.after), widen(sd_before, row.rounded ? row.sd.before : "");
      widen(lower, row.lower.after), widen(upper_before, row.upper.before);
    }
  }
};

std::string before(const std::string& text, std::size_t width) {
  return fmt::format("<span class=\"b\" style=\"min-width:{}ch\">{}</span>", width, number(text));
}

std::string after(const std::string& text, std::size_t width) {
  return width == 0 ? number(text)
                    : fmt::format("<span class=\"f\" style=\"min-width:{}ch\">{}</span>", width, number(text));
}

std::string power(int exponent) { return number(fmt::format("1e{}", exponent)).substr(1); }

/// "(−4.12" and "± 0.33) × 10⁻⁵" in two cells. In Chinese "±" means an expanded uncertainty: value and standard
/// uncertainty stand alone there, each with its power.
std::string value_cells(const ParameterRow& row, const Widths& widths, const Words& words) {
  const bool chinese = words.language == Language::chinese;
  const std::string tail = row.exponent == 0 ? "" : power(row.exponent);
  const bool bracket = !tail.empty() && !chinese;
  std::string text = fmt::format("<td class=\"n value\">{}{}{}{}</td>", bracket ? "(" : "", number(row.value.before),
                                 after(row.value.after, widths.value), chinese ? tail : "");
  if (row.sd.before.empty()) return text + "<td></td>";
  return text + fmt::format("<td class=\"sd\">{}{}{}{}</td>", chinese ? "" : "± ",
                            before(result_words_in(words.language, row.sd.before).value_or(row.sd.before),
                                   row.rounded ? widths.sd_before : 0),
                            number(row.sd.after + (bracket ? ")" : "")), tail);
}

std::string interval_cells(const ParameterRow& row, const Widths& widths) {
  if (row.lower.before.empty()) return "<td class=\"n low\">–</td><td></td>";
  return fmt::format("<td class=\"n low\">[{}{}</td><td class=\"high\">{}{}{}</td>", number(row.lower.before),
                     after(row.lower.after + ",", widths.lower + 1), before(row.upper.before, widths.upper_before),
                     number(row.upper.after + "]"), row.exponent == 0 ? "" : power(row.exponent));
}

std::string row_html(const ParameterRow& row, const Parameter& parameter, const Widths& widths, bool with_freedom,
                     const std::string& method, const Words& words) {
  std::string text = fmt::format("<tr><td class=\"symbol\">{}</td><th scope=\"row\">{}",
                                 row.symbol.empty() ? "" : symbol(row.symbol), name_html(row.name, words, method));
  if (!row.description.empty()) text += fmt::format("<span class=\"description\">{}</span>", escaped(row.description));
  text += "</th>" + value_cells(row, widths, words) + fmt::format("<td class=\"in\">{}</td>", unit(parameter.unit)) +
          interval_cells(row, widths);
  if (with_freedom) text += fmt::format("<td class=\"n freedom\">{}</td>", number(row.degrees_of_freedom));
  return text + "</tr>\n";
}

std::string section(const Estimate& estimate, const std::string& id, const std::string& title, const std::string& note,
                    const Words& words) {
  if (estimate.parameters.empty()) return {};
  const bool with_freedom =
      std::ranges::any_of(estimate.parameters, [](const auto& p) { return std::isfinite(p.degrees_of_freedom); });
  // In Chinese value and standard uncertainty have a heading each.
  const std::string values =
      words.language == Language::chinese
          ? fmt::format("<th scope=\"col\">{}</th><th scope=\"col\">{}</th>", words("value"), words("sd"))
          : fmt::format("<th scope=\"colgroup\" colspan=\"2\" class=\"middle\">{}</th>", words("value_and_sd"));
  std::string text = fmt::format(
      "<section id=\"{}\">\n<h2>{}</h2>\n<div class=\"wide\" tabindex=\"0\"><table class=\"parameters\">\n<thead><tr>"
      "<th scope=\"col\">{}</th><th scope=\"col\">{}</th>{}<th scope=\"col\">{}</th>"
      "<th scope=\"colgroup\" colspan=\"2\" class=\"middle\">{}</th>",
      id, title, words("symbol"), words("parameter"), values, words("unit"), words("interval"));
  if (with_freedom) text += "<th scope=\"col\" class=\"n\">" + words("degrees_of_freedom") + "</th>";
  text += "</tr></thead>\n<tbody>\n";
  const auto rows = parameter_rows(estimate);
  const Widths widths(rows);
  for (std::size_t i = 0; i < rows.size(); ++i)
    text += row_html(rows[i], estimate.parameters[i], widths, with_freedom, estimate.method, words);
  return text + "</tbody></table></div>\n<p class=\"note\">" + note + "</p>\n</section>\n";
}

}  // namespace

std::string parameters(const Estimate& estimate, const Words& words) {
  return section(estimate, "parameters", words("parameters"), words("sd_note"), words);
}

std::string with_prior(const Estimate& estimate, const Words& words) {
  if (!estimate.prior || !estimate.prior->with_prior) return {};
  const auto& use = *estimate.prior;
  const auto note = words.with("prior_note", std::to_string(use.population->population->units),
                               escaped(first_digits(use.population->population->sha256))) +
                    (words.language == Language::chinese ? "" : " ") +
                    words(use.verdicts ? "verdicts_with_prior" : "verdicts_without_prior");
  return section(*use.with_prior, "with_prior", words("with_prior"), note, words);
}

}  // namespace tumble::html
