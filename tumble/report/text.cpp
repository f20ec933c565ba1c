#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/report/report.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/report/shape.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/report/utf8.hpp"

namespace tumble {
namespace {

using Align = TextColumn::Align;

std::string unit_text(const Unit& unit) { return unit.text() == "1" ? "" : printable(unit.text()); }

std::string heading(const Estimate& estimate) {
  std::string text = printable(estimate.title.empty() ? estimate.method : estimate.title) + "\n";
  std::string below = estimate.title.empty() ? "" : "method " + printable(estimate.method);
  const auto add = [&](const std::string& part) { below += (below.empty() ? "" : " · ") + part; };
  if (!estimate.instrument_model.empty()) add("instrument " + printable(estimate.instrument_model));
  if (!estimate.instrument_serial.empty()) add("serial " + printable(estimate.instrument_serial));
  return below.empty() ? text : text + below + "\n";
}

/// Pads the texts on the left so that their "±" stand below each other.
void line_up_signs(std::vector<std::string>& cells) {
  const auto before = [](const std::string& cell) { return display_width(cell.substr(0, cell.find("±"))); };
  std::size_t most = 0;
  for (const auto& cell : cells) most = std::max(most, before(cell));
  for (auto& cell : cells) cell.insert(0, most - before(cell), ' ');
}

std::string parameters_text(const Estimate& estimate, const std::string& title, std::size_t width) {
  if (estimate.parameters.empty()) return {};
  TextColumn name{"parameter", "", {}, Align::left}, value{"value ± sd", "", {}, Align::left};
  TextColumn unit{"unit", "", {}, Align::left}, interval{"95 % interval", "", {}, Align::left};
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const auto& parameter = estimate.parameters[i];
    const auto [number, sd] = shown(estimate, i);
    name.cells.push_back(printable(parameter.name));
    value.cells.push_back(with_uncertainty(number, sd));
    unit.cells.push_back(printable(parameter.unit.text()));
    interval.cells.push_back(interval_text(estimate, i));
  }
  line_up_signs(value.cells);
  return "\n" + title + "\n" + text_table({name, value, unit, interval}, width);
}

std::string prior_text(const Estimate& estimate, std::size_t width) {
  if (!estimate.prior || !estimate.prior->with_prior) return {};
  const auto& use = *estimate.prior;
  return parameters_text(*use.with_prior,
                         fmt::format("Parameters with the prior of {} units ({})", use.population->population->units,
                                     use.verdicts ? "the verdicts rest on these" : "the verdicts do not rest on these"),
                         width);
}

std::string budget_text(const Estimate& estimate, std::size_t width) {
  if (estimate.budget.empty() || estimate.parameters.empty()) return {};
  std::vector<TextColumn> columns{{"parameter", "", {}, Align::left}, {"unit", "", {}, Align::left}};
  for (const auto& parameter : estimate.parameters) {
    columns[0].cells.push_back(printable(parameter.name));
    columns[1].cells.push_back(printable(parameter.unit.text()));
  }
  for (const auto& part : budget_to_show(estimate)) {
    auto& column = columns.emplace_back(TextColumn{printable(part.source), "", {}, Align::right});
    for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
      const auto [sd, share] = budget_cell(estimate, part, i);
      column.cells.push_back(fmt::format("{} {:>5}", sd, share));
    }
  }
  return "\nUncertainty budget (standard uncertainty from each source, and its share of the variance)\n" +
         text_table(columns, width);
}

std::string fit_text(const Fit& fit, std::size_t width) {
  if (fit.observations == 0) return {};
  std::string text =
      fmt::format("{} observations, {} degrees of freedom", fit.observations, general(fit.degrees_of_freedom));
  if (std::isfinite(fit.chi_square) && fit.degrees_of_freedom > 0.0) {
    text += fmt::format(", chi-square {} ({:#.3g} per degree of freedom)", general(fit.chi_square),
                        fit.chi_square / fit.degrees_of_freedom);
  }
  if (fit.condition > 0.0) text += fmt::format(", condition number {}", general(fit.condition, 3));
  return "\n" + wrapped("Fit: ", text, width);
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

std::string table_text(const Table& table, std::size_t width) {
  std::size_t left_out = 0;
  const auto rows = shown_rows(table.rows.size(), left_out);
  std::vector<TextColumn> columns;
  for (std::size_t i = 0; i < table.columns.size(); ++i) columns.push_back(table_column(table, i, rows));
  const auto name = "Table " + printable(table.name);
  std::string text =
      "\n" + (table.caption.empty() ? name + "\n" : wrapped(name + ": ", printable(table.caption), width));
  text += text_table(columns, width);
  if (left_out > 0) {
    text += fmt::format("  ({} rows from the middle of {} are not shown; the result file and the report have all)\n",
                        left_out, table.rows.size());
  }
  return text;
}

std::string findings_text(const Findings& findings, std::size_t width) {
  if (findings.empty()) return {};
  constexpr std::array words{"info", "warning", "error"};
  auto sorted = findings;
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.severity > b.severity; });
  std::string text = "\nFindings\n";
  for (const auto& finding : sorted) {
    const auto word = fmt::format("  {:<9}", words[static_cast<std::size_t>(finding.severity)]);
    const auto where = finding.where.empty() ? "" : printable(finding.where) + ": ";
    text += wrapped(word, where + printable(finding.message), width);
  }
  return text;
}

std::string verdicts_text(const Estimate& estimate, std::size_t width) {
  if (estimate.verdicts.empty()) return {};
  constexpr std::array words{"PASS", "FAIL", "UNDECIDED"};
  TextColumn outcome{"outcome", "", {}, Align::left}, parameter{"parameter", "", {}, Align::left};
  TextColumn limit{"limit", "", {}, Align::left}, measured{"measured", "", {}, Align::left};
  for (const auto& verdict : estimate.verdicts) {
    outcome.cells.push_back(words[static_cast<std::size_t>(verdict.outcome)]);
    parameter.cells.push_back(printable(verdict.parameter));
    limit.cells.push_back(printable(verdict.limit));
    measured.cells.push_back(measured_text(judged(estimate), verdict.parameter));
  }
  return "\nVerdicts\n" + text_table({outcome, parameter, limit, measured}, width);
}

}  // namespace

std::string to_text(const Estimate& estimate, std::size_t width) {
  require_shape(estimate);
  std::string text = heading(estimate) +
                     parameters_text(estimate, "Parameters (± standard uncertainty, k = 1)", width) +
                     prior_text(estimate, width) + budget_text(estimate, width) + fit_text(estimate.fit, width);
  for (const auto& table : estimate.tables)
    if (!table.for_programs) text += table_text(table, width);
  return text + findings_text(estimate.findings, width) + verdicts_text(estimate, width);
}

}  // namespace tumble
