#include "tumble/report/html/html.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/report/report.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/report/shape.hpp"
#include "tumble/version.hpp"

namespace tumble::assets {
extern const std::string_view report_css;
}

namespace tumble::html {
namespace {

// The page has no script, and no address outside it can be loaded, whatever a name tries.
constexpr const char* security =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";

std::string head(const std::string& title) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"generator\" content=\"Tumble {}\">\n<title>{}</title>\n<style>\n{}</style>\n</head>\n",
      security, version, title, assets::report_css);
}

std::string entry(const char* name, const std::string& value) {
  return value.empty() ? "" : fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", name, value);
}

std::string fit_entry(const Fit& fit) {
  if (fit.observations == 0) return {};
  auto text = fmt::format("{} observations, {} degrees of freedom", fit.observations,
                          html::number(general(fit.degrees_of_freedom)));
  if (std::isfinite(fit.chi_square) && fit.degrees_of_freedom > 0.0) {
    text += fmt::format(", χ² per degree of freedom {:#.3g}", fit.chi_square / fit.degrees_of_freedom);
  }
  if (fit.condition > 0.0) text += ", condition number " + html::number(general(fit.condition, 3));
  return text;
}

std::string outcome_count(const Estimate& estimate, Verdict::Outcome outcome, const char* kind, const char* text) {
  std::size_t count = 0;
  for (const auto& verdict : estimate.verdicts) count += verdict.outcome == outcome;
  return count == 0 ? "" : fmt::format("<span class=\"badge {}\">{} {}</span> ", kind, count, text);
}

std::string summary(const Estimate& estimate) {
  const auto errors = std::count_if(estimate.findings.begin(), estimate.findings.end(),
                                    [](const auto& f) { return f.severity == Finding::Severity::error; });
  const auto text = outcome_count(estimate, Verdict::Outcome::fail, "bad", "failed") +
                    outcome_count(estimate, Verdict::Outcome::undecided, "open", "undecided") +
                    outcome_count(estimate, Verdict::Outcome::pass, "good", "passed") +
                    (errors == 0 ? "" : fmt::format("<span class=\"badge bad\">error findings: {}</span>", errors));
  return text.empty() ? "" : "<p class=\"summary\">" + text + "</p>\n";
}

std::string title_block(const Estimate& estimate, const std::string& title, const std::string& logo) {
  return "<header>\n" + (logo.empty() ? "" : "<img class=\"logo\" alt=\"\" src=\"" + escaped(logo) + "\">\n") + "<h1>" +
         title + "</h1>\n<dl>" + entry("Instrument", html::escaped(estimate.instrument_model)) +
         entry("Serial", html::escaped(estimate.instrument_serial)) + entry("Method", html::escaped(estimate.method)) +
         entry("Fit", fit_entry(estimate.fit)) + "</dl>\n" + summary(estimate) + "</header>\n";
}

/// Links to the sections that are there.
std::string navigation(const std::string& sections) {
  std::string text = "<nav aria-label=\"Sections\">";
  for (const auto& [id, name] :
       std::initializer_list<std::pair<const char*, const char*>>{{"verdicts", "Verdicts"},
                                                                  {"parameters", "Parameters"},
                                                                  {"findings", "Findings"},
                                                                  {"budget", "Uncertainty budget"},
                                                                  {"figures", "Figures"},
                                                                  {"tables", "Tables"},
                                                                  {"correlation", "Correlation"},
                                                                  {"provenance", "Provenance"}}) {
    if (sections.find(fmt::format("<section id=\"{}\">", id)) == std::string::npos) continue;
    text += fmt::format("<a href=\"#{}\">{}</a> ", id, name);
  }
  return text + "</nav>\n";
}

}  // namespace

}  // namespace tumble::html

namespace tumble {

using namespace html;

std::string to_html(const Estimate& estimate, const PageOptions& page) {
  require_shape(estimate);
  const auto& own = estimate.title.empty() ? estimate.method : estimate.title;
  const auto title = html::escaped(page.title.empty() ? own : page.title);
  const auto sections = html::verdicts(estimate) + html::parameters(estimate) + html::findings(estimate) +
                        html::budget(estimate) + html::figures(estimate) + html::tables(estimate) +
                        html::correlation(estimate) + html::provenance(estimate);
  return head(title) + "<body>\n" + title_block(estimate, title, page.logo) + navigation(sections) + "<main>\n" +
         sections + "</main>\n<footer>Made by Tumble " + version + "</footer>\n</body>\n</html>\n";
}

}  // namespace tumble
