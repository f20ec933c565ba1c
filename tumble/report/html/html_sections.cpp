#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tumble/report/html/html.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/rounding.hpp"

namespace tumble::html {
namespace {

/// An icon, a word and a colour, so that none of the three is needed alone.
std::string badge(const char* kind, const char* icon, const char* word) {
  return fmt::format("<span class=\"badge {}\"><span aria-hidden=\"true\">{}</span> {}</span>", kind, icon, word);
}

std::string verdict_badge(Verdict::Outcome outcome) {
  switch (outcome) {
    case Verdict::Outcome::pass:
      return badge("good", "✓", "Pass");
    case Verdict::Outcome::fail:
      return badge("bad", "✗", "Fail");
    default:
      return badge("open", "?", "Undecided");
  }
}

/// "<= 0.02 deg/h" with the printed sign.
std::string limit(const std::string& text) {
  if (text.starts_with("<=")) return "≤" + escaped(text.substr(2));
  if (text.starts_with(">=")) return "≥" + escaped(text.substr(2));
  return escaped(text);
}

std::string finding_badge(Finding::Severity severity) {
  switch (severity) {
    case Finding::Severity::error:
      return badge("bad", "✗", "Error");
    case Finding::Severity::warning:
      return badge("open", "!", "Warning");
    default:
      return badge("plain", "i", "Info");
  }
}

/// "(−4.12" and "± 0.33) × 10⁻⁵" in two cells, so that the signs stand below each other.
std::string value_cells(double value, double sd) {
  const auto text = with_uncertainty(value, sd);
  const auto sign = text.find(" ±");
  if (sign == std::string::npos) return fmt::format("<td class=\"n value\">{}</td><td></td>", number(text));
  return fmt::format("<td class=\"n value\">{}</td><td class=\"sd\">{}</td>", number(text.substr(0, sign)),
                     number(text.substr(sign + 1)));
}

std::string parameter_row(const Estimate& estimate, std::size_t i, bool with_freedom) {
  const auto& parameter = estimate.parameters[i];
  const auto [value, sd] = shown(estimate, i);
  std::string text = fmt::format("<tr><td class=\"symbol\">{}</td><th scope=\"row\">{}",
                                 parameter.symbol.empty() ? "" : symbol(parameter.symbol), escaped(parameter.name));
  if (!parameter.description.empty()) {
    text += fmt::format("<span class=\"description\">{}</span>", escaped(parameter.description));
  }
  text += "</th>" + value_cells(value, sd) + fmt::format("<td>{}</td>", unit(parameter.unit));
  text += fmt::format("<td class=\"interval\">{}</td>", number(interval_text(estimate, i)));
  if (with_freedom) {
    const double freedom = parameter.degrees_of_freedom;
    text += fmt::format("<td class=\"n\">{}</td>", std::isinf(freedom) ? "∞" : number(general(freedom, 3)));
  }
  return text + "</tr>\n";
}

struct TableColumn {
  std::vector<std::string> cells;
  bool all_text = true;
};

/// Figure space and punctuation space are as wide as a digit and as the point.
TableColumn table_column(const Table& table, std::size_t index) {
  std::vector<double> numbers;
  for (const auto& row : table.rows) {
    const auto* value = std::get_if<double>(&row[index]);
    numbers.push_back(value ? table.columns[index].unit.from_si(*value) : NAN);
  }
  TableColumn column{lined_up(numbers, "\u2007", "\u2008"), true};
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto* text = std::get_if<std::string>(&table.rows[i][index]);
    column.cells[i] = text ? escaped(*text) : number(column.cells[i]);
    if (!text) column.all_text = false;
  }
  return column;
}

std::string table_html(const Table& table, std::size_t count) {
  std::vector<TableColumn> columns;
  for (std::size_t i = 0; i < table.columns.size(); ++i) columns.push_back(table_column(table, i));
  std::string text =
      fmt::format("<div class=\"scroll\" tabindex=\"0\"><table>\n<caption><b>Table {}.</b> {}{}</caption>\n", count,
                  escaped(table.name), table.caption.empty() ? "" : ": " + escaped(table.caption));
  text += "<thead><tr>";
  for (std::size_t i = 0; i < columns.size(); ++i) {
    text += fmt::format("<th scope=\"col\"{}>{}<span class=\"unit\">{}</span></th>",
                        columns[i].all_text ? "" : " class=\"n\"", escaped(table.columns[i].name),
                        unit(table.columns[i].unit));
  }
  text += "</tr></thead>\n<tbody>\n";
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    text += "<tr>";
    for (const auto& column : columns) {
      text += (column.all_text ? "<td>" : "<td class=\"n\">") + column.cells[row] + "</td>";
    }
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

double correlation_of(const Estimate& estimate, std::size_t i, std::size_t j) {
  const auto& covariance = estimate.covariance;
  return i == j ? 1.0 : covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
}

/// White at 0 to blue at +1 and orange at -1.
std::string heat_cell(double r) {
  if (!std::isfinite(r)) return "<td>–</td>";
  const double depth = std::min(1.0, std::abs(r));
  const std::array<double, 3> full = r > 0 ? std::array{0.0, 90.0, 160.0} : std::array{190.0, 80.0, 0.0};
  std::string colour = "#";
  for (const double channel : full) colour += fmt::format("{:02x}", std::lround(255.0 + depth * (channel - 255.0)));
  const bool zero = std::lround(100.0 * r) == 0;
  return fmt::format("<td style=\"background:{}{}\">{}</td>", colour, depth > 0.55 ? ";color:#fff" : "",
                     zero ? "0" : number(fmt::format("{:.2f}", r)));
}

/// The pairs that the data hardly tell apart, in words.
std::string strong_pairs(const Estimate& estimate) {
  constexpr double strong = 0.9;
  constexpr std::size_t most = 10;
  std::size_t count = 0;
  std::string text;
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    for (std::size_t j = i + 1; j < estimate.parameters.size(); ++j) {
      const double r = correlation_of(estimate, i, j);
      if (!(std::abs(r) >= strong) || ++count > most) continue;
      text += fmt::format("{}{} and {} ({})", text.empty() ? "" : "; ", escaped(estimate.parameters[i].name),
                          escaped(estimate.parameters[j].name), number(fmt::format("{:.3f}", r)));
    }
  }
  if (count == 0) return "<p>No two parameters are correlated by 0.9 or more.</p>\n";
  if (count > most) text += fmt::format("; and {} more", count - most);
  return "<p>Correlated by 0.9 or more: " + text + ".</p>\n";
}

std::string heat_map(const Estimate& estimate) {
  const auto count = estimate.parameters.size();
  std::string text = fmt::format(
      "<div class=\"wide\"><table class=\"heat{}\">\n<caption>Correlation coefficients; the "
      "columns are numbered as the rows</caption>\n<thead><tr><td></td>",
      count > 16 ? " dense" : "");
  for (std::size_t j = 0; j < count; ++j) {
    text += fmt::format("<th scope=\"col\" title=\"{}\">{}</th>", escaped(estimate.parameters[j].name), j + 1);
  }
  text += "</tr></thead>\n<tbody>\n";
  for (std::size_t i = 0; i < count; ++i) {
    text += fmt::format("<tr><th scope=\"row\">{} {}</th>", i + 1, escaped(estimate.parameters[i].name));
    for (std::size_t j = 0; j < count; ++j) text += heat_cell(correlation_of(estimate, i, j));
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

std::string texts_table(const char* caption, const std::map<std::string, std::string>& texts) {
  if (texts.empty()) return {};
  std::string text = fmt::format(
      "<table>\n<caption>{}</caption>\n<thead><tr><th scope=\"col\">Name</th><th scope=\"col\">"
      "Value</th></tr></thead>\n<tbody>\n",
      caption);
  for (const auto& [key, value] : texts) {
    text += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escaped(key), escaped(value));
  }
  return text + "</tbody></table>\n";
}

std::string hash_row(const std::string& file, const std::string& sha256) {
  return fmt::format("<tr><th scope=\"row\">{}</th><td class=\"hash\">{}</td></tr>\n", escaped(file), escaped(sha256));
}

std::string inputs_table(const Provenance& provenance) {
  if (provenance.inputs.empty() && provenance.plans.empty()) return {};
  std::string text =
      "<table>\n<caption>Input files</caption>\n<thead><tr><th scope=\"col\">File</th><th scope=\"col\">"
      "SHA-256</th></tr></thead>\n<tbody>\n";
  for (const auto& plan : provenance.plans) text += hash_row(plan.file, plan.sha256);
  for (const auto& input : provenance.inputs) text += hash_row(input.file, input.sha256);
  return text + "</tbody></table>\n";
}

std::string plan_text(const Provenance::PlanFile& plan) {
  if (!plan.text) return {};
  return fmt::format("<details>\n<summary>The plan {}</summary>\n<pre>{}</pre>\n</details>\n", escaped(plan.file),
                     escaped(*plan.text));
}

}  // namespace

std::string verdicts(const Estimate& estimate) {
  if (estimate.verdicts.empty()) return {};
  std::string text =
      "<section id=\"verdicts\">\n<h2>Verdicts</h2>\n<table>\n<thead><tr><th scope=\"col\">Outcome</th><th "
      "scope=\"col\">"
      "Parameter</th><th scope=\"col\">Limit</th><th scope=\"col\">Measured</th></tr></thead>\n<tbody>\n";
  for (const auto& verdict : estimate.verdicts) {
    const auto* parameter = find_parameter(estimate, verdict.parameter);
    std::string measured;
    if (parameter != nullptr) {
      const auto [value, sd] = shown(estimate, static_cast<std::size_t>(parameter - estimate.parameters.data()));
      measured = number(with_uncertainty(value, sd)) + " " + unit(parameter->unit);
    } else if (const auto upper = find_upper_limit(estimate, verdict.parameter)) {
      measured =
          fmt::format("below {} {} (95 %)", number(general(upper->unit.from_si(upper->value), 3)), unit(upper->unit));
    }
    text += fmt::format("<tr><td>{}</td><th scope=\"row\">{}</th><td>{}</td><td>{}</td></tr>\n",
                        verdict_badge(verdict.outcome), escaped(verdict.parameter), limit(verdict.limit), measured);
  }
  return text +
         "</tbody></table>\n<p class=\"note\">Judged by the 95 % interval. Undecided: the limit lies inside it."
         "</p>\n</section>\n";
}

std::string parameters(const Estimate& estimate) {
  if (estimate.parameters.empty()) return {};
  const bool with_freedom = std::any_of(estimate.parameters.begin(), estimate.parameters.end(),
                                        [](const auto& p) { return std::isfinite(p.degrees_of_freedom); });
  std::string text =
      "<section id=\"parameters\">\n<h2>Parameters</h2>\n<div class=\"wide\"><table "
      "class=\"parameters\">\n<thead><tr>"
      "<th scope=\"col\">Symbol</th><th scope=\"col\">Parameter</th><th scope=\"colgroup\" colspan=\"2\" "
      "class=\"middle\">Value ± sd</th><th scope=\"col\">Unit</th><th scope=\"col\">95 % "
      "interval</th>";
  if (with_freedom) text += "<th scope=\"col\" class=\"n\">Degrees of freedom</th>";
  text += "</tr></thead>\n<tbody>\n";
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) text += parameter_row(estimate, i, with_freedom);
  text +=
      "</tbody></table></div>\n<p class=\"note\">Standard uncertainty: k = 1, everything in the budget together, "
      "rounded to two digits.</p>\n";
  return text + "</section>\n";
}

std::string findings(const Estimate& estimate) {
  if (estimate.findings.empty()) return {};
  auto sorted = estimate.findings;
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.severity > b.severity; });
  std::string text = "<section id=\"findings\">\n<h2>Findings</h2>\n<ul class=\"findings\">\n";
  for (const auto& finding : sorted) {
    text += fmt::format("<li>{}<div>{}", finding_badge(finding.severity), escaped(finding.message));
    if (!finding.where.empty()) text += fmt::format("<span class=\"where\">{}</span>", escaped(finding.where));
    text += "</div></li>\n";
  }
  return text + "</ul>\n</section>\n";
}

std::string tables(const Estimate& estimate) {
  if (estimate.tables.empty()) return {};
  std::string text = "<section id=\"tables\">\n<h2>Tables</h2>\n";
  for (std::size_t i = 0; i < estimate.tables.size(); ++i) text += table_html(estimate.tables[i], i + 1);
  return text + "</section>\n";
}

std::string correlation(const Estimate& estimate) {
  constexpr std::size_t most = 40;
  const auto count = estimate.parameters.size();
  if (count < 2) return {};
  const auto shown_matrix = count <= most
                                ? heat_map(estimate)
                                : fmt::format("<p>The matrix of {} parameters is in the result file.</p>\n", count);
  return "<section id=\"correlation\">\n<h2>Correlation</h2>\n" + strong_pairs(estimate) + shown_matrix +
         "</section>\n";
}

std::string provenance(const Estimate& estimate) {
  const auto& provenance = estimate.provenance;
  std::string text = "<section id=\"provenance\">\n<h2>Provenance</h2>\n" + inputs_table(provenance);
  text += texts_table("Settings", provenance.settings);
  text += texts_table("Values of the command line (--set)", provenance.command_line);
  for (const auto& plan : provenance.plans) text += plan_text(plan);
  if (provenance.seed) text += fmt::format("<p>Simulated with seed {}.</p>\n", *provenance.seed);
  return text + "</section>\n";
}

}  // namespace tumble::html
