#include "tumble/report/html/html.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/language/said.hpp"
#include "tumble/report/in_language.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/report/shape.hpp"
#include "tumble/version.hpp"

namespace tumble::html {
namespace {

// The page has no script, and no address outside it can be loaded, whatever a name tries.
constexpr const char* security =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";

std::string head(const std::string& title, const std::string& style, Language language) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<meta name=\"generator\" content=\"Tumble {}\">\n<title>{}</title>\n<style>\n{}</style>\n</head>\n",
      language == Language::chinese ? "zh-CN" : "en", security, version, title, style);
}

std::string entry(const std::string& name, const std::string& value) {
  return value.empty() ? "" : fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", name, value);
}

std::string fit_entry(const Fit& fit, const Words& words) {
  if (fit.observations == 0) return {};
  auto text =
      words.with("fit_observations", std::to_string(fit.observations), html::number(general(fit.degrees_of_freedom)));
  if (std::isfinite(fit.chi_square) && fit.degrees_of_freedom > 0.0)
    text += words.with("fit_chi_square", fmt::format("{:#.3g}", fit.chi_square / fit.degrees_of_freedom));
  if (fit.condition > 0.0) text += words.with("fit_condition", html::number(general(fit.condition, 3)));
  return text;
}

std::string outcome_count(const Estimate& estimate, Verdict::Outcome outcome, const char* kind,
                          const std::string& text) {
  std::size_t count = 0;
  for (const auto& verdict : estimate.verdicts) count += verdict.outcome == outcome;
  return count == 0 ? "" : fmt::format("<span class=\"badge {}\">{} {}</span> ", kind, count, text);
}

std::string summary(const Estimate& estimate, const Words& words) {
  const auto errors = std::count_if(estimate.findings.begin(), estimate.findings.end(),
                                    [](const auto& f) { return f.severity == Finding::Severity::error; });
  const auto text =
      outcome_count(estimate, Verdict::Outcome::fail, "bad", words("failed")) +
      outcome_count(estimate, Verdict::Outcome::undecided, "open", words("still_undecided")) +
      outcome_count(estimate, Verdict::Outcome::pass, "good", words("passed")) +
      (errors == 0 ? "" : "<span class=\"badge bad\">" + words.with("errors", std::to_string(errors)) + "</span>");
  return text.empty() ? "" : "<p class=\"summary\">" + text + "</p>\n";
}

/// The title of a result that has none: its method.
std::string readable_title(const std::string& method, Language language) {
  return result_words_in(language, method).value_or(method);
}

/// In Chinese the name of the method before its key.
std::string method_html(const std::string& method, const Words& words) {
  return words.language == Language::english ? escaped(method) : name_html(method, words);
}

/// Above all numbers: they are of no instrument.
std::string specimen(const Estimate& estimate, const Words& words) {
  const auto& seed = estimate.provenance.seed;
  return seed ? "<p class=\"specimen\">" + words.with("specimen", std::to_string(*seed)) + "</p>\n" : "";
}

std::string title_block(const Estimate& estimate, const std::string& title, const std::string& logo,
                        const Words& words) {
  return "<header>\n" + (logo.empty() ? "" : "<img class=\"logo\" alt=\"\" src=\"" + escaped(logo) + "\">\n") + "<h1>" +
         title + "</h1>\n<dl>" + entry(words("instrument"), html::escaped(estimate.instrument_model)) +
         entry(words("serial"), html::escaped(estimate.instrument_serial)) +
         entry(words("method"), method_html(estimate.method, words)) +
         entry(words("fit"), fit_entry(estimate.fit, words)) + "</dl>\n" + specimen(estimate, words) +
         summary(estimate, words) + "</header>\n";
}

/// A section of the page with its anchor; empty: the result has nothing to show in it.
struct PageSection {
  const char* id;
  std::string content;
};

std::vector<PageSection> sections_of(const Estimate& estimate, const std::vector<Figure>& drawn, const Words& words) {
  return {{"verdicts", verdicts(estimate, words)},       {"figure", first_figure(drawn, words)},
          {"parameters", parameters(estimate, words)},   {"with_prior", with_prior(estimate, words)},
          {"findings", findings(estimate, words)},       {"budget", budget(estimate, words)},
          {"figures", further_figures(drawn, words)},    {"tables", tables(estimate, words)},
          {"correlation", correlation(estimate, words)}, {"provenance", provenance(estimate, words)}};
}

/// Links to the sections that are there.
std::string navigation(const std::vector<PageSection>& sections, const Words& words) {
  std::string text = "<nav aria-label=\"" + words("sections") + "\">";
  for (const auto& [id, content] : sections) {
    if (content.empty()) continue;
    text += fmt::format("<a href=\"#{}\">{}</a> ", id, words(id == std::string_view("figure") ? "first_figure" : id));
  }
  return text + "</nav>\n";
}

}  // namespace

}  // namespace tumble::html

namespace tumble {

using namespace html;

std::string to_html(const Estimate& original, const PageOptions& page) {
  require_shape(original);
  const auto drawn = in_language(page.language, figures_of(original));
  const bool english = page.language == Language::english;
  const Estimate translated = english ? Estimate() : in_language(page.language, original);
  const Estimate& estimate = english ? original : translated;
  const auto own = estimate.title.empty() ? readable_title(estimate.method, page.language) : estimate.title;
  const auto& plain_title = page.title.empty() ? own : page.title;
  const auto title = html::escaped(plain_title);
  const html::Words words{page.language, "report"};
  const auto sections = sections_of(estimate, drawn, words);
  std::string content;
  for (const auto& section : sections) content += section.content;
  const auto serial = estimate.instrument_serial.empty() ? "" : words("serial") + " " + estimate.instrument_serial;
  return head(title, html::style(plain_title, serial), page.language) + "<body>\n" +
         title_block(estimate, title, page.logo, words) + navigation(sections, words) + "<main>\n" + content +
         "</main>\n<footer>" + words.with("made_by", version) + "</footer>\n</body>\n</html>\n";
}

}  // namespace tumble
