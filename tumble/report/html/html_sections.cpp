#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tumble/core/message_in.hpp"
#include "tumble/language/said.hpp"
#include "tumble/report/html/html.hpp"
#include "tumble/report/limit_text.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/rounding.hpp"

namespace tumble::html {
namespace {

/// An icon, a word and a colour, so that none of the three is needed alone.
std::string badge(const char* kind, const char* icon, const std::string& word) {
  return fmt::format("<span class=\"badge {}\"><span aria-hidden=\"true\">{}</span> {}</span>", kind, icon, word);
}

std::string verdict_badge(Verdict::Outcome outcome, const Words& words) {
  switch (outcome) {
    case Verdict::Outcome::pass:
      return badge("good", "✓", words("pass"));
    case Verdict::Outcome::fail:
      return badge("bad", "✗", words("fail"));
    default:
      return badge("open", "?", words("undecided"));
  }
}

std::string finding_badge(Finding::Severity severity, const Words& words) {
  switch (severity) {
    case Finding::Severity::error:
      return badge("bad", "✗", words("error"));
    case Finding::Severity::warning:
      return badge("open", "!", words("warning"));
    default:
      return badge("plain", "i", words("info"));
  }
}

/// "unknown" in the language of the page; numbers stay.
std::string said(const std::string& text, const Words& words) {
  return result_words_in(words.language, text).value_or(text);
}

/// "6.660 ± 0.011 deg/h", in Chinese "6.660 deg/h，u = 0.011 deg/h（k = 1）".
std::string measured(double value, double sd, const Unit& in, const Words& words) {
  const auto shown_unit = " " + unit(in);
  if (words.language == Language::english) return number(with_uncertainty(value, sd)) + shown_unit;
  const auto halves = value_and_sd(value, sd);
  if (halves.sd.empty()) return number(said(halves.value, words)) + shown_unit;
  const auto tail = in.text() == "1" ? "" : shown_unit;
  return words.with("measured", number(halves.value) + tail, number(said(halves.sd, words)) + tail);
}

std::string texts_table(const std::string& caption, const std::map<std::string, std::string>& texts,
                        const Words& words) {
  if (texts.empty()) return {};
  std::string text = fmt::format(
      "<table>\n<caption>{}</caption>\n<thead><tr><th scope=\"col\">{}</th><th scope=\"col\">{}</th></tr></thead>\n"
      "<tbody>\n",
      caption, words("name"), words("value"));
  for (const auto& [key, value] : texts) {
    text += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escaped(key), escaped(value));
  }
  return text + "</tbody></table>\n";
}

std::string hash_row(const std::string& file, const std::string& sha256) {
  return fmt::format("<tr><th scope=\"row\">{}</th><td class=\"hash\">{}</td></tr>\n", escaped(file), escaped(sha256));
}

std::string inputs_table(const Provenance& provenance, const Words& words) {
  if (provenance.inputs.empty() && provenance.plans.empty()) return {};
  std::string text = fmt::format(
      "<table>\n<caption>{}</caption>\n<thead><tr><th scope=\"col\">{}</th><th "
      "scope=\"col\">SHA-256</th></tr></thead>\n"
      "<tbody>\n",
      words("input_files"), words("file"));
  for (const auto& plan : provenance.plans) text += hash_row(plan.file, plan.sha256);
  for (const auto& input : provenance.inputs) text += hash_row(input.file, input.sha256);
  return text + "</tbody></table>\n";
}

std::string plan_text(const Provenance::PlanFile& plan, const Words& words) {
  if (!plan.text) return {};
  return fmt::format("<details>\n<summary>{}</summary>\n<pre>{}</pre>\n</details>\n",
                     words.with("plan", escaped(plan.file)), escaped(*plan.text));
}

}  // namespace

std::string verdicts(const Estimate& whole, const Words& words) {
  if (whole.verdicts.empty()) return {};
  const Estimate& estimate = judged(whole);
  std::string text = fmt::format(
      "<section id=\"verdicts\">\n<h2>{}</h2>\n<table class=\"verdicts\">\n<thead><tr><th scope=\"col\">{}</th><th "
      "scope=\"col\">{}</th>"
      "<th scope=\"col\">{}</th><th scope=\"col\">{}</th></tr></thead>\n<tbody>\n",
      words("verdicts"), words("outcome"), words("parameter"), words("limit"), words("measured_value"));
  for (const auto& verdict : whole.verdicts) {
    const auto* parameter = find_parameter(estimate, verdict.parameter);
    std::string value;
    if (parameter != nullptr) {
      const auto known = shown(estimate, static_cast<std::size_t>(parameter - estimate.parameters.data()));
      value = measured(known.value, known.sd, parameter->unit, words);
    } else if (const auto upper = find_upper_limit(whole, verdict.parameter)) {
      value = words.with("below", number(general(upper->unit.from_si(upper->value), 3)), unit(upper->unit));
    }
    text += fmt::format("<tr><td>{}</td><th scope=\"row\">{}</th><td>{}</td><td>{}</td></tr>\n",
                        verdict_badge(verdict.outcome, words), name_html(verdict.parameter, words, whole.method),
                        escaped(limit_in_characters(verdict.limit)), value);
  }
  return text + "</tbody></table>\n<p class=\"note\">" + words("judged_by") + "</p>\n</section>\n";
}

std::string findings(const Estimate& estimate, const Words& words) {
  if (estimate.findings.empty()) return {};
  auto sorted = estimate.findings;
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.severity > b.severity; });
  std::string text = "<section id=\"findings\">\n<h2>" + words("findings") + "</h2>\n";
  text += "<ul class=\"findings\">\n";
  for (const auto& finding : sorted) {
    text += fmt::format("<li>{}<div>{}", finding_badge(finding.severity, words),
                        escaped(message_in(words.language, finding)));
    if (!finding.where.empty()) text += fmt::format("<span class=\"where\">{}</span>", escaped(finding.where));
    text += "</div></li>\n";
  }
  return text + "</ul>\n</section>\n";
}

std::string provenance(const Estimate& estimate, const Words& words) {
  const auto& provenance = estimate.provenance;
  std::string text =
      "<section id=\"provenance\">\n<h2>" + words("provenance") + "</h2>\n" + inputs_table(provenance, words);
  text += texts_table(words("settings"), provenance.settings, words);
  text += texts_table(words("command_line"), provenance.command_line, words);
  for (const auto& plan : provenance.plans) text += plan_text(plan, words);
  if (provenance.seed) text += "<p>" + words.with("seed", std::to_string(*provenance.seed)) + "</p>\n";
  return text + "</section>\n";
}

}  // namespace tumble::html
