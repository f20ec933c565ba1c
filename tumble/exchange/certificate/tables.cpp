#include <algorithm>
#include <cmath>

#include "tumble/exchange/certificate/page.hpp"
#include "tumble/exchange/certificate/work.hpp"
#include "tumble/language/said.hpp"
#include "tumble/report/limit_text.hpp"
#include "tumble/report/markup.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/report/typeset.hpp"

namespace tumble::certificate {
namespace {

/// Columns of numbers have their heading to the right.
std::string header_row(const Words& words, std::initializer_list<const char*> keys,
                       std::initializer_list<std::string_view> of_numbers = {}) {
  std::string text = "<thead><tr>";
  for (const char* key : keys)
    text += fmt::format("<th scope=\"col\"{}>{}</th>",
                        std::ranges::find(of_numbers, key) == of_numbers.end() ? "" : " class=\"n\"", words(key));
  return text + "</tr></thead>\n<tbody>\n";
}

/// A number [unit shown] with the digits of an uncertainty.
std::string rounded_to(double value, const Rounding& rounding) {
  if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
  return typeset_number(rounded(value, rounding));
}

/// U [unit shown], two values where the interval is not symmetric, and k.
struct UncertaintyCells {
  std::string u, k;
};

UncertaintyCells uncertainty_cells(const Estimate& estimate, std::size_t index, const Rounding& rounding) {
  const Measured measured = measured_of(estimate, index);
  const Unit& unit = estimate.parameters[index].unit;
  const auto [below, above] = expanded_uncertainty(measured);
  const double down = unit.difference_from_si(below), up = unit.difference_from_si(above);
  if (std::isfinite(measured.lower) && std::isfinite(measured.upper))
    return {"−" + rounded_to(down, rounding) + " / +" + rounded_to(up, rounding), "–"};
  const double k = below / measured.sd;
  return {rounded_to(up, rounding), fmt::format("{:.{}f}", k, k < 100.0 ? 2 : 0)};
}

Rounding rounding_of(const Estimate& estimate, std::size_t index) {
  const auto [below, above] = expanded_uncertainty(measured_of(estimate, index));
  const Unit& unit = estimate.parameters[index].unit;
  const double smaller = std::min(below, above) > 0.0 ? std::min(below, above) : std::max(below, above);
  return rounding_for(unit.from_si(estimate.parameters[index].value), unit.difference_from_si(smaller));
}

std::string result_row(const Estimate& estimate, std::size_t index, const Words& words) {
  const auto& parameter = estimate.parameters[index];
  const Rounding rounding = rounding_of(estimate, index);
  const auto cells = uncertainty_cells(estimate, index, rounding);
  return fmt::format(
      "<tr><td class=\"symbol\">{}</td><th scope=\"row\">{}{}</th><td class=\"n\">{}</td><td class=\"n\">{}</td>"
      "<td class=\"k\">{}</td><td class=\"unit\">{}</td></tr>\n",
      parameter.symbol.empty() ? "" : words.symbol(parameter.symbol), words.name(parameter.name, estimate.method),
      parameter.description.empty() || parameter.description == parameter.name
          ? ""
          : "<span class=\"description\">" +
                escaped(result_words_in(words.language, parameter.description).value_or(parameter.description)) +
                "</span>",
      rounded_to(parameter.unit.from_si(parameter.value), rounding), cells.u, cells.k, words.unit(parameter.unit));
}

const char* colour_of(Decision::Outcome outcome) {
  using enum Decision::Outcome;
  if (outcome == pass) return "good";
  return outcome == fail ? "bad" : "open";
}

/// "≤ 0.02 deg/h".
std::string allowed_text(const Statement& statement, const Estimate& estimate, const Words& words) {
  if (!statement.index) return escaped(limit_text(statement.limit));
  const Unit& unit = estimate.parameters[*statement.index].unit;
  const auto number = [&](double si) { return typeset_number(general(unit.from_si(si), 10)); };
  const auto [lower, upper] = statement.tolerance;
  if (std::isinf(lower)) return "≤ " + number(upper) + " " + words.unit(unit);
  if (std::isinf(upper)) return "≥ " + number(lower) + " " + words.unit(unit);
  return number(lower) + " … " + number(upper) + " " + words.unit(unit);
}

std::string acceptance_text(const Statement& statement, const Estimate& estimate) {
  if (!statement.decision || statement.decision->acceptance.empty()) return "–";
  const Rounding rounding = rounding_of(estimate, *statement.index);
  const Unit& unit = estimate.parameters[*statement.index].unit;
  const auto number = [&](double si) { return rounded_to(unit.from_si(si), rounding); };
  const auto [lower, upper] = statement.decision->acceptance;
  if (std::isinf(lower)) return "≤ " + number(upper);
  if (std::isinf(upper)) return "≥ " + number(lower);
  return number(lower) + " … " + number(upper);
}

std::string measured_below(const Statement& statement, const Estimate& estimate, const Words& words) {
  if (statement.index) return "";
  const auto upper = find_upper_limit(estimate, statement.parameter);
  if (!upper) return "";
  return "<span class=\"description\">" +
         words.with("below", typeset_number(general(upper->unit.from_si(upper->value), 3)), words.unit(upper->unit)) +
         "</span>";
}

std::string statement_row(const Statement& statement, const Estimate& estimate, const Words& words) {
  const auto& decision = statement.decision;
  const double ratio = decision ? decision->test_uncertainty_ratio : NAN;
  return fmt::format(
      "<tr><th scope=\"row\">{}{}</th><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>"
      "<td class=\"outcome {}\">{}</td></tr>\n",
      words.name(statement.parameter, estimate.method), measured_below(statement, estimate, words),
      allowed_text(statement, estimate, words), acceptance_text(statement, estimate),
      std::isfinite(ratio) ? fmt::format("{:.3g}", ratio) : "–",
      decision ? escaped(percent(decision->conformance)) + (words.language == Language::chinese ? "%" : " %") : "–",
      colour_of(statement.outcome), outcome_in_words(statement.outcome, words.language));
}

std::string paragraph(const std::string& text, const char* kind = "") {
  return fmt::format("<p{}>{}</p>\n", *kind == 0 ? std::string() : fmt::format(" class=\"{}\"", kind), text);
}

/// Whether one of the words of a unit is g, mg or ug: those of "deg/h/g", not those of "deg/h".
bool is_in_g(std::string_view unit) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  while (!unit.empty()) {
    const auto length = static_cast<std::size_t>(std::ranges::find_if_not(unit, is_letter) - unit.begin());
    const auto word = unit.substr(0, length);
    if (word == "g" || word == "mg" || word == "ug") return true;
    unit.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return false;
}

bool any_in_g(const Estimate& estimate) {
  return std::ranges::any_of(estimate.parameters, [](const Parameter& parameter) {
    return std::isfinite(parameter.value) && is_in_g(parameter.unit.text());
  });
}

/// A value with at least the decimals of its uncertainty: 23.0 with 0.5.
std::string to_the_digit_of(double value, double uncertainty) {
  return lined_up({value, uncertainty}, "0", ".").front();
}

}  // namespace

std::string conditions_table(const Certificate& certificate, const Words& words) {
  std::string text = "<section><h2>" + words("conditions") + "</h2>\n<table>\n" +
                     header_row(words, {"condition", "value", "expanded_uncertainty", "unit"});
  for (const auto& condition : certificate.details.conditions) {
    const double value = condition.unit.from_si(condition.value);
    const double u = condition.uncertainty ? condition.unit.difference_from_si(*condition.uncertainty) : NAN;
    text +=
        fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td class=\"unit\">{}</td></tr>\n",
                    escaped(condition.name), typeset_number(to_the_digit_of(value, u)),
                    condition.uncertainty ? typeset_number(general(u)) + " (k = 2)" : "–", words.unit(condition.unit));
  }
  return text + "</tbody></table></section>\n";
}

std::string equipment_table(const Certificate& certificate, const Words& words) {
  const auto& all = certificate.details.equipment;
  if (all.empty()) return {};
  std::string text = "<section><h2>" + words("equipment") + "</h2>\n<table>\n" +
                     header_row(words, {"equipment_name", "model", "serial", "equipment_certificate", "equipment_due",
                                        "equipment_traceable"});
  std::string notes;
  const auto& ended = certificate.details.ended;
  for (const auto& one : all) {
    const std::string due = one.due ? words.date(*one.due) : "–";
    const std::string model = one.manufacturer.empty() ? one.model : one.manufacturer + " " + one.model;
    text += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                        escaped(one.name), escaped(model), escaped(one.serial), escaped(one.certificate), due,
                        escaped(one.traceable_to));
    if (one.due && ended && *one.due < *ended)
      notes += paragraph(words.with("out_of_date", escaped(one.name), due, escaped(one.accepted_out_of_date)));
  }
  return text + "</tbody></table>\n" + notes + "</section>\n";
}

std::string results_table(const Certificate& certificate, const Words& words) {
  const auto& estimate = certificate.estimate;
  std::string text =
      "<section><h2>" + words("results") + "</h2>\n<table>\n" +
      header_row(words, {"symbol", "quantity", "value", "expanded_uncertainty", "coverage_factor", "unit"},
                 {"value", "expanded_uncertainty"});
  bool two_sided = false;
  for (const std::size_t index : determined(estimate)) {
    text += result_row(estimate, index, words);
    two_sided = two_sided || std::isfinite(estimate.parameters[index].lower);
  }
  text += "</tbody></table>\n" + paragraph(words("uncertainty_note"), "note");
  if (two_sided) text += paragraph(words("two_sided_note"), "note");
  if (any_in_g(estimate)) text += paragraph(words("standard_g"), "note");
  return text + "</section>\n";
}

std::string conformity(const Certificate& certificate, const Words& words) {
  const auto& details = certificate.details;
  if (certificate.statements.empty()) return "<section>" + paragraph(words("no_statement")) + "</section>\n";
  std::string text = "<section><h2>" + words("conformity") + "</h2>\n<table>\n" +
                     header_row(words, {"quantity", "limit", "acceptance", "ratio", "probability", "statement"},
                                {"acceptance", "ratio", "probability"});
  bool undecided = false;
  for (const auto& statement : certificate.statements) {
    text += statement_row(statement, certificate.estimate, words);
    undecided = undecided || statement.outcome == Decision::Outcome::undecided;
  }
  text += "</tbody></table>\n" + paragraph(words.with("rule_named", words("rule"), name(*details.rule)) +
                                           escaped(rule_in_words(*details.rule, words.language)) +
                                           (details.rule_agreed_with.empty()
                                                ? ""
                                                : " " + words.with("rule_agreed", escaped(details.rule_agreed_with))));
  text += paragraph(words("before_rounding"), "note");
  if (undecided) text += paragraph(words("rule_undecided"));
  if (certificate.joint) text += paragraph(words.with("joint", escaped(percent(*certificate.joint))));
  for (const auto& statement : certificate.statements)
    if (statement.global_risk)
      text += paragraph(words.with("global_risk", escaped(statement.parameter),
                                   escaped(percent(statement.global_risk->consumer)),
                                   escaped(percent(statement.global_risk->producer))));
  return text + "</section>\n";
}

}  // namespace tumble::certificate
