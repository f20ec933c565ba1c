#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tumble/core/message_in.hpp"
#include "tumble/report/html/html.hpp"
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

/// "<= 0.02 deg/h" with the printed sign.
std::string limit(const std::string& text) {
  if (text.starts_with("<=")) return "≤" + escaped(text.substr(2));
  if (text.starts_with(">=")) return "≥" + escaped(text.substr(2));
  return escaped(text);
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

/// "(−4.12" and "± 0.33) × 10⁻⁵" in two cells, so that the signs stand below each other. In Chinese "±" means an
/// expanded uncertainty: value and standard uncertainty stand alone there.
std::string value_cells(double value, double sd, const Words& words) {
  const auto text = with_uncertainty(value, sd);
  const auto sign = text.find(" ±");
  if (sign == std::string::npos) return fmt::format("<td class=\"n value\">{}</td><td></td>", number(text));
  if (const auto rounding = rounding_for(value, sd); words.language == Language::chinese && rounding.significant)
    return fmt::format("<td class=\"n value\">{}</td><td class=\"sd\">{}</td>", number(rounded(value, rounding)),
                       number(rounded(sd, rounding)));
  return fmt::format("<td class=\"n value\">{}</td><td class=\"sd\">{}</td>", number(text.substr(0, sign)),
                     number(text.substr(sign + 1)));
}

/// "6.660 ± 0.011", in Chinese "6.660，u = 0.011".
std::string measured(double value, double sd, const Words& words) {
  const auto rounding = rounding_for(value, sd);
  if (words.language == Language::chinese && rounding.significant)
    return words.with("measured", number(rounded(value, rounding)), number(rounded(sd, rounding)));
  return number(with_uncertainty(value, sd));
}

std::string parameter_row(const Estimate& estimate, std::size_t i, bool with_freedom, const Words& words) {
  const auto& parameter = estimate.parameters[i];
  const auto [value, sd] = shown(estimate, i);
  std::string text = fmt::format("<tr><td class=\"symbol\">{}</td><th scope=\"row\">{}",
                                 parameter.symbol.empty() ? "" : symbol(parameter.symbol), escaped(parameter.name));
  if (!parameter.description.empty()) {
    text += fmt::format("<span class=\"description\">{}</span>", escaped(parameter.description));
  }
  text += "</th>" + value_cells(value, sd, words) + fmt::format("<td>{}</td>", unit(parameter.unit));
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

std::string table_html(const Table& table, std::size_t count, const Words& words) {
  std::vector<TableColumn> columns;
  for (std::size_t i = 0; i < table.columns.size(); ++i) columns.push_back(table_column(table, i));
  std::string text = fmt::format("<div class=\"scroll\" tabindex=\"0\"><table>\n<caption><b>{}.</b> {}{}</caption>\n",
                                 words.with("table", std::to_string(count)), escaped(table.name),
                                 table.caption.empty() ? "" : ": " + escaped(table.caption));
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
std::string strong_pairs(const Estimate& estimate, const Words& words) {
  constexpr double strong = 0.9;
  constexpr std::size_t most = 10;
  std::size_t count = 0;
  std::string text;
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    for (std::size_t j = i + 1; j < estimate.parameters.size(); ++j) {
      const double r = correlation_of(estimate, i, j);
      if (!(std::abs(r) >= strong) || ++count > most) continue;
      if (!text.empty()) text += words("next_pair");
      text += words.with("pair", escaped(estimate.parameters[i].name), escaped(estimate.parameters[j].name),
                         number(fmt::format("{:.3f}", r)));
    }
  }
  if (count == 0) return "<p>" + words("no_strong_pair") + "</p>\n";
  if (count > most) text += words.with("more_pairs", std::to_string(count - most));
  return "<p>" + words.with("strong_pairs", text) + "</p>\n";
}

std::string heat_map(const Estimate& estimate, const Words& words) {
  const auto count = estimate.parameters.size();
  std::string text =
      fmt::format("<div class=\"wide\"><table class=\"heat{}\">\n<caption>{}</caption>\n<thead><tr><td></td>",
                  count > 16 ? " dense" : "", words("correlation_caption"));
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
      "<section id=\"verdicts\">\n<h2>{}</h2>\n<table>\n<thead><tr><th scope=\"col\">{}</th><th scope=\"col\">{}</th>"
      "<th scope=\"col\">{}</th><th scope=\"col\">{}</th></tr></thead>\n<tbody>\n",
      words("verdicts"), words("outcome"), words("parameter"), words("limit"), words("measured_value"));
  for (const auto& verdict : whole.verdicts) {
    const auto* parameter = find_parameter(estimate, verdict.parameter);
    std::string value;
    if (parameter != nullptr) {
      const auto known = shown(estimate, static_cast<std::size_t>(parameter - estimate.parameters.data()));
      value = measured(known.value, known.sd, words) + " " + unit(parameter->unit);
    } else if (const auto upper = find_upper_limit(whole, verdict.parameter)) {
      value = words.with("below", number(general(upper->unit.from_si(upper->value), 3)), unit(upper->unit));
    }
    text += fmt::format("<tr><td>{}</td><th scope=\"row\">{}</th><td>{}</td><td>{}</td></tr>\n",
                        verdict_badge(verdict.outcome, words), escaped(verdict.parameter), limit(verdict.limit), value);
  }
  return text + "</tbody></table>\n<p class=\"note\">" + words("judged_by") + "</p>\n</section>\n";
}

namespace {

std::string parameter_section(const Estimate& estimate, const std::string& id, const std::string& title,
                              const std::string& note, const Words& words) {
  if (estimate.parameters.empty()) return {};
  const bool with_freedom = std::any_of(estimate.parameters.begin(), estimate.parameters.end(),
                                        [](const auto& p) { return std::isfinite(p.degrees_of_freedom); });
  // In Chinese value and standard uncertainty have a heading each.
  const std::string values =
      words.language == Language::chinese
          ? fmt::format("<th scope=\"col\">{}</th><th scope=\"col\">{}</th>", words("value"), words("sd"))
          : fmt::format("<th scope=\"colgroup\" colspan=\"2\" class=\"middle\">{}</th>", words("value_and_sd"));
  std::string text = fmt::format(
      "<section id=\"{}\">\n<h2>{}</h2>\n<div class=\"wide\"><table class=\"parameters\">\n<thead><tr>"
      "<th scope=\"col\">{}</th><th scope=\"col\">{}</th>{}<th scope=\"col\">{}</th><th scope=\"col\">{}</th>",
      id, title, words("symbol"), words("parameter"), values, words("unit"), words("interval"));
  if (with_freedom) text += "<th scope=\"col\" class=\"n\">" + words("degrees_of_freedom") + "</th>";
  text += "</tr></thead>\n<tbody>\n";
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) text += parameter_row(estimate, i, with_freedom, words);
  text += "</tbody></table></div>\n<p class=\"note\">" + note + "</p>\n";
  return text + "</section>\n";
}

}  // namespace

std::string parameters(const Estimate& estimate, const Words& words) {
  return parameter_section(estimate, "parameters", words("parameters"), words("sd_note"), words);
}

std::string with_prior(const Estimate& estimate, const Words& words) {
  if (!estimate.prior || !estimate.prior->with_prior) return {};
  const auto& use = *estimate.prior;
  const auto note = words.with("prior_note", std::to_string(use.population->population->units),
                               escaped(use.population->population->sha256.substr(0, 12))) +
                    " " + words(use.verdicts ? "verdicts_with_prior" : "verdicts_without_prior");
  return parameter_section(*use.with_prior, "with_prior", words("with_prior"), note, words);
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

std::string tables(const Estimate& estimate, const Words& words) {
  if (estimate.tables.empty()) return {};
  std::string text = "<section id=\"tables\">\n<h2>" + words("tables") + "</h2>\n";
  if (const auto note = words("tables_note"); !note.empty()) text += "<p class=\"note\">" + note + "</p>\n";
  for (std::size_t i = 0; i < estimate.tables.size(); ++i) text += table_html(estimate.tables[i], i + 1, words);
  return text + "</section>\n";
}

std::string correlation(const Estimate& estimate, const Words& words) {
  constexpr std::size_t most = 40;
  const auto count = estimate.parameters.size();
  if (count < 2) return {};
  const auto shown_matrix =
      count <= most ? heat_map(estimate, words) : "<p>" + words.with("large_matrix", std::to_string(count)) + "</p>\n";
  return "<section id=\"correlation\">\n<h2>" + words("correlation") + "</h2>\n" + strong_pairs(estimate, words) +
         shown_matrix + "</section>\n";
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
