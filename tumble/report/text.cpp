#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/core/message_in.hpp"
#include "tumble/language/said.hpp"
#include "tumble/language/section_words.hpp"
#include "tumble/report/in_language.hpp"
#include "tumble/report/limit_text.hpp"
#include "tumble/report/names.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/report/shape.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/report/utf8.hpp"

namespace tumble {
namespace {

using Align = TextColumn::Align;

using Words = SectionWords;

std::string unit_text(const Unit& unit) { return unit.text() == "1" ? "" : printable(unit.text()); }

constexpr std::size_t heading_width = 100;  ///< [columns] of a line, as the report has

std::string heading(const Estimate& estimate, const Words& words) {
  const auto method = result_words_in(words.language, estimate.method);  // by its Chinese name, its key behind it
  const auto key = method ? *method + words.with("in_parentheses", estimate.method) : estimate.method;
  std::string text = printable(estimate.title.empty() ? key : estimate.title) + "\n";
  std::string below = estimate.title.empty() ? "" : words.with("method_is", printable(key));
  std::size_t line = display_width(below);
  const auto add = [&](const std::string& part) {
    const bool next = line > 0 && line + 3 + display_width(part) > heading_width;
    below += (below.empty() ? "" : next ? "\n" : " · ") + part;
    line = (next ? 0 : line + 3) + display_width(part);
  };
  if (!estimate.instrument_model.empty()) add(words.with("instrument_is", printable(estimate.instrument_model)));
  if (!estimate.instrument_serial.empty()) add(words.with("serial_is", printable(estimate.instrument_serial)));
  if (const auto& seed = estimate.provenance.seed) add(words.with("specimen_of_seed", std::to_string(*seed)));
  return below.empty() ? text : text + below + "\n";
}

/// Pads the texts on the left so that their "±" stand below each other.
void line_up_signs(std::vector<std::string>& cells) {
  const auto before = [](const std::string& cell) { return display_width(cell.substr(0, cell.find("±"))); };
  std::size_t most = 0;
  for (const auto& cell : cells) most = std::max(most, before(cell));
  for (auto& cell : cells) cell.insert(0, most - before(cell), ' ');
}

/// "6.660 ± 0.011" of each parameter in one column; in Chinese value and standard uncertainty in one each.
std::vector<TextColumn> value_columns(const Estimate& estimate, const Words& words) {
  const bool apart = words.language == Language::chinese;
  TextColumn value{words("value_and_sd"), "", {}, Align::left}, sd{words("sd"), "", {}, Align::right};
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const auto known = shown(estimate, i);
    const auto halves = value_and_sd(known.value, known.sd);
    value.cells.push_back(apart ? halves.value : with_uncertainty(known.value, known.sd));
    sd.cells.push_back(result_words_in(words.language, halves.sd).value_or(halves.sd));
  }
  if (!apart) line_up_signs(value.cells);
  value.align = apart ? Align::right : Align::left;
  return apart ? std::vector{value, sd} : std::vector{value};
}

std::string parameters_text(const Estimate& estimate, const std::string& title, const Words& words, std::size_t width) {
  if (estimate.parameters.empty()) return {};
  TextColumn name{words("parameter"), "", {}, Align::left}, unit{words("unit"), "", {}, Align::left};
  TextColumn interval{words("interval"), "", {}, Align::left};
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    name.cells.push_back(printable(estimate.parameters[i].name));
    unit.cells.push_back(printable(estimate.parameters[i].unit.text()));
    interval.cells.push_back(interval_text(estimate, i));
  }
  std::vector<TextColumn> columns{name};
  for (auto& column : value_columns(estimate, words)) columns.push_back(std::move(column));
  columns.push_back(unit), columns.push_back(interval);
  return "\n" + title + "\n" + text_table(columns, width);
}

std::string prior_text(const Estimate& estimate, const Words& words, std::size_t width) {
  if (!estimate.prior || !estimate.prior->with_prior) return {};
  const auto& use = *estimate.prior;
  return parameters_text(*use.with_prior,
                         words.with("parameters_with_prior", use.population->population->units,
                                    words(use.verdicts ? "verdicts_with_prior" : "verdicts_without_prior")),
                         words, width);
}

std::string budget_text(const Estimate& estimate, const Words& words, std::size_t width) {
  if (estimate.budget.empty() || estimate.parameters.empty()) return {};
  std::vector<TextColumn> columns{{words("parameter"), "", {}, Align::left}, {words("unit"), "", {}, Align::left}};
  for (const auto& parameter : estimate.parameters) {
    columns[0].cells.push_back(printable(parameter.name));
    columns[1].cells.push_back(printable(parameter.unit.text()));
  }
  for (const auto& part : budget_to_show(estimate, words.language)) {
    auto& column = columns.emplace_back(TextColumn{printable(part.source), "", {}, Align::right});
    for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
      const auto [sd, share] = budget_cell(estimate, part, i, words.language);
      column.cells.push_back(fmt::format("{} {:>5}", sd, share));
    }
  }
  return "\n" + words("budget") + "\n" + text_table(columns, width);
}

std::string fit_text(const Fit& fit, const Words& words, std::size_t width) {
  if (fit.observations == 0) return {};
  std::string text = words.with("fit_observations", fit.observations, general(fit.degrees_of_freedom));
  if (std::isfinite(fit.chi_square) && fit.degrees_of_freedom > 0.0) {
    text += words.with("fit_chi_square", general(fit.chi_square),
                       fmt::format("{:#.3g}", fit.chi_square / fit.degrees_of_freedom));
  }
  if (fit.condition > 0.0) text += words.with("fit_condition", general(fit.condition, 3));
  return "\n" + wrapped(words("fit"), text, width);
}

/// The rows that are shown: all of a short table, the first and last of a long one.
std::vector<std::size_t> shown_rows(std::size_t count, std::size_t& left_out) {
  constexpr std::size_t most = 30, first = 15, last = 5;
  left_out = count > most ? count - first - last : 0;
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < count; ++i) {
    if (left_out == 0 || i < first || i >= count - last) rows.push_back(i);
  }
  return rows;
}

TextColumn table_column(const Table& table, std::size_t index, const std::vector<std::size_t>& rows) {
  TextColumn column{printable(table.columns[index].name), unit_text(table.columns[index].unit), {}, Align::right};
  std::vector<double> numbers;
  for (const auto row : rows) {
    const auto* number = std::get_if<double>(&table.rows[row][index]);
    numbers.push_back(number ? table.columns[index].unit.from_si(*number) : NAN);
  }
  column.cells = lined_up(numbers, " ", " ");
  bool all_text = true;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (const auto* text = std::get_if<std::string>(&table.rows[rows[i]][index])) {
      column.cells[i] = printable(*text);
    } else {
      all_text = false;
    }
  }
  if (all_text) column.align = Align::left;
  return column;
}

std::string table_text(const Table& table, const std::string& method, const Words& words, std::size_t width) {
  std::size_t left_out = 0;
  const auto rows = shown_rows(table.rows.size(), left_out);
  std::vector<TextColumn> columns;
  for (std::size_t i = 0; i < table.columns.size(); ++i) columns.push_back(table_column(table, i, rows));
  const auto key = printable(table.name);
  const bool english = words.language == Language::english;  // else by its name, with its key behind it
  const auto name = words.with(
      "table", english ? key : readable_name(words.language, key, method) + words.with("in_parentheses", key));
  std::string text =
      "\n" + (table.caption.empty() ? name + "\n" : wrapped(name + words("colon"), printable(table.caption), width));
  text += text_table(columns, width);
  if (left_out > 0) {
    text += "  " + words.with("rows_not_shown", left_out, table.rows.size()) + "\n";
  }
  return text;
}

std::string findings_text(const Findings& findings, const Words& words, std::size_t width) {
  if (findings.empty()) return {};
  auto sorted = findings;
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.severity > b.severity; });
  std::string text = "\n" + words("findings") + "\n";
  for (const auto& finding : sorted) {
    const auto word = "  " + padded(severity_in(words.language, finding.severity), 9, Align::left);
    text += wrapped(word, printable(placed_message_in(words.language, finding)), width);
  }
  return text;
}

std::string verdicts_text(const Estimate& estimate, const Words& words, std::size_t width) {
  if (estimate.verdicts.empty()) return {};
  constexpr std::array keys{"pass", "fail", "undecided"};
  TextColumn outcome{words("outcome"), "", {}, Align::left}, parameter{words("parameter"), "", {}, Align::left};
  TextColumn limit{words("limit"), "", {}, Align::left}, measured{words("measured"), "", {}, Align::left};
  for (const auto& verdict : estimate.verdicts) {
    outcome.cells.push_back(words(keys[static_cast<std::size_t>(verdict.outcome)]));
    parameter.cells.push_back(printable(verdict.parameter));
    limit.cells.push_back(printable(limit_text(verdict.limit)));
    measured.cells.push_back(measured_text(judged(estimate), verdict.parameter, words.language));
  }
  return "\n" + words("verdicts") + "\n" + text_table({outcome, parameter, limit, measured}, width);
}

}  // namespace

std::string to_text(const Estimate& original, std::size_t width, Language language) {
  require_shape(original);
  const bool english = language == Language::english;
  const Estimate translated = english ? Estimate() : in_language(language, original);
  const Estimate& estimate = english ? original : translated;
  const Words words{language};
  std::string text = heading(estimate, words) + parameters_text(estimate, words("parameters"), words, width) +
                     prior_text(estimate, words, width) + budget_text(estimate, words, width) +
                     fit_text(estimate.fit, words, width);
  for (const auto& table : estimate.tables)
    if (!table.for_programs) text += table_text(table, estimate.method, words, width);
  return text + findings_text(estimate.findings, words, width) + verdicts_text(estimate, words, width);
}

std::string to_text(const Findings& findings, std::size_t width, Language language) {
  const Words words{language};
  if (findings.empty()) return words("no_findings") + "\n";
  std::string text = words("findings_list") + "\n";
  for (const auto& finding : findings) {
    const auto where = finding.where.empty() ? "" : words.with("in_parentheses", printable(finding.where));
    text += wrapped(words.with("severity_before", severity_in(language, finding.severity)),
                    printable(message_in(language, finding)) + where, width);
  }
  return text;
}

}  // namespace tumble
