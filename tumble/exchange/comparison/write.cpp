#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tumble/core/message_in.hpp"
#include "tumble/exchange/comparison.hpp"
#include "tumble/language/section_words.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/report/utf8.hpp"

namespace tumble {
namespace {

using ComparisonJson = nlohmann::ordered_json;

std::string marked(const Difference& one) {
  const auto text = texts_of(one).e_n;
  return std::isnan(one.e_n) ? text : text + (std::abs(one.e_n) > 1.0 ? " *" : "  ");
}

std::string pair_text(const Comparison& comparison, const ResultPair& pair, const SectionWords& words,
                      std::size_t width) {
  TextColumn names{.name = words("parameter"), .unit = "", .cells = {}, .align = TextColumn::Align::left};
  TextColumn units{.name = words("unit"), .unit = "", .cells = {}, .align = TextColumn::Align::left};
  TextColumn earlier{.name = words("earlier"), .unit = "", .cells = {}};
  TextColumn later{.name = words("later"), .unit = "", .cells = {}};
  TextColumn difference{.name = words("difference_and_u"), .unit = "", .cells = {}};
  TextColumn e_n{.name = "E_n", .unit = "", .cells = {}};
  for (const auto& one : pair.differences) {
    const auto texts = texts_of(one);
    names.cells.push_back(printable(one.parameter));
    units.cells.push_back(one.unit.text() == "1" ? "" : one.unit.text());
    earlier.cells.push_back(texts.earlier), later.cells.push_back(texts.later);
    difference.cells.push_back(texts.difference);
    e_n.cells.push_back(marked(one));
  }
  const auto& results = comparison.results;
  return fmt::format("{} -> {}\n", printable(results[pair.earlier].name), printable(results[pair.later].name)) +
         text_table({names, earlier, later, difference, units, e_n}, width) + "  " +
         words.with("all_together", chi_square_text(pair, words.language)) + "\n";
}

ComparisonJson finite_or_null(double value) {
  return std::isfinite(value) ? ComparisonJson(value) : ComparisonJson(nullptr);
}

ComparisonJson difference_json(const Difference& one) {
  const Unit& unit = one.unit;
  return {{"parameter", one.parameter},
          {"unit", unit.text()},
          {"earlier", finite_or_null(unit.from_si(one.earlier))},
          {"later", finite_or_null(unit.from_si(one.later))},
          {"difference", finite_or_null(unit.difference_from_si(one.difference))},
          {"sd", finite_or_null(unit.difference_from_si(one.sd))},
          {"degrees_of_freedom", finite_or_null(one.degrees_of_freedom)},
          {"expanded95", finite_or_null(unit.difference_from_si(one.expanded))},
          {"shared_covariance", finite_or_null(one.shared_covariance / (unit.factor() * unit.factor()))},
          {"e_n", finite_or_null(one.e_n)}};
}

}  // namespace

DifferenceTexts texts_of(const Difference& one) {
  const double step = one.unit.difference_from_si(one.difference), u = one.unit.difference_from_si(one.expanded);
  const Rounding rounding = rounding_for(step, u);
  const auto number = [&](double si) {
    return mantissa(one.unit.from_si(si), {rounding.place, 0, rounding.significant});
  };
  return {number(one.earlier), number(one.later), with_uncertainty(step, u),
          std::isnan(one.e_n)       ? "–"
          : std::abs(one.e_n) < 1e4 ? fmt::format("{:.2f}", one.e_n)
                                    : fmt::format("{:.3g}", one.e_n)};
}

std::string chi_square_text(const ResultPair& pair, Language language) {
  return SectionWords{language}.with(
      "chi_square", fmt::format("{:.3g}", pair.chi_square), pair.rank,
      pair.probability < 1e-9 ? "p < 1e-9" : fmt::format("p = {:.2g}", pair.probability));
}

std::string to_text(const Comparison& comparison, std::size_t width, Language language) {
  const SectionWords words{language};
  std::string text;
  for (const auto& pair : comparison.pairs)
    text += (text.empty() ? "" : "\n") + pair_text(comparison, pair, words, width);
  text += "\n" + wrapped("", words("comparison_note"), width);
  for (const auto& finding : comparison.findings)
    text += wrapped(padded(severity_in(language, finding.severity), 9, TextColumn::Align::left),
                    placed_message_in(language, finding), width);
  return text;
}

std::string to_json(const Comparison& comparison) {
  ComparisonJson json;
  json["results"] = ComparisonJson::array();
  for (const auto& [name, estimate] : comparison.results)
    json["results"].push_back({{"file", printable(name)},
                               {"method", printable(estimate.method)},
                               {"model", printable(estimate.instrument_model)},
                               {"serial", printable(estimate.instrument_serial)}});
  json["pairs"] = ComparisonJson::array();
  for (const auto& pair : comparison.pairs) {
    ComparisonJson one{{"earlier", pair.earlier}, {"later", pair.later}, {"differences", ComparisonJson::array()}};
    for (const auto& difference : pair.differences) one["differences"].push_back(difference_json(difference));
    one["chi_square"] = finite_or_null(pair.chi_square), one["degrees_of_freedom"] = pair.rank;
    one["probability"] = pair.probability;
    json["pairs"].push_back(std::move(one));
  }
  json["findings"] = ComparisonJson::parse(to_json(comparison.findings));
  return json.dump(1) + "\n";
}

}  // namespace tumble
