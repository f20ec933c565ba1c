#include "tumble/tasks/optimisation/report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/tasks/optimisation/criteria.hpp"
#include "tumble/tasks/optimisation/work.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::optimisation {
namespace {

using Cell = Table::Cell;

const Unit one;

/// Four digits in the unit shown: these are predictions.
Cell number(double value_si, const Unit& unit = one) {
  if (!std::isfinite(value_si) || value_si == 0.0) return std::string("-");
  const double shown = value_si / unit.factor(), digit = std::pow(10.0, std::floor(std::log10(std::abs(shown))) - 3.0);
  return rounded_to_digits(std::round(shown / digit) * digit, 6) * unit.factor();
}

Table criteria_table(const std::vector<ScheduleRow>& rows, const std::vector<std::string>& terms,
                     const std::vector<double>& reference) {
  std::vector<Criteria> criteria;
  for (const auto& row : rows)
    criteria.push_back(row.estimate ? criteria_of(with_prior_if_any(*row.estimate), terms, reference) : Criteria());
  const auto hidden = [&](std::size_t i) {
    std::vector<std::string> names;
    for (std::size_t k = 0; k < terms.size(); ++k)
      if (std::isinf(criteria[i].sd[k])) names.push_back(terms[k]);
    return names;
  };
  const auto if_predicted = [&](auto of) {
    return [&, of](std::size_t i) { return rows[i].estimate ? Cell(of(i)) : "-"; };
  };
  const auto determined = [&](std::size_t i) {
    return fmt::format("{} of {}", terms.size() - hidden(i).size(), terms.size());
  };
  const auto not_distinguished = [&](std::size_t i) {
    return rows[i].estimate ? fmt::format("{}", fmt::join(hidden(i), ", ")) : rows[i].refused.text();
  };
  return tabulate(
      "schedules",
      "each in the same total time, except the plan as it is. det, trace, worst: uncertainty relative to the "
      "reference of each parameter as geometric mean over all directions, root mean square and largest; "
      "smaller is better",
      rows.size(),
      {{"schedule", [&](std::size_t i) { return rows[i].name; }},
       {"segments", [&](std::size_t i) { return rows[i].schedule.size(); }},
       {"time", "min", [&](std::size_t i) { return total_of(rows[i].schedule); }},
       {"determined", if_predicted(determined)},
       {"det", if_predicted([&](std::size_t i) { return number(criteria[i].determinant); })},
       {"trace", if_predicted([&](std::size_t i) { return number(criteria[i].trace); })},
       {"worst", if_predicted([&](std::size_t i) { return number(criteria[i].worst); })},
       {"condition", if_predicted([&](std::size_t i) { return number(rows[i].estimate->fit.condition); })},
       {"not distinguished", not_distinguished}});
}

Table sd_table(const std::vector<ScheduleRow>& rows, const Estimate& chosen, const std::vector<std::string>& terms,
               const std::vector<double>& reference) {
  using Line = std::pair<std::string, std::vector<double>>;  // name, sd of each term [SI]
  std::vector<Line> lines;
  for (const auto& row : rows)
    if (row.estimate) lines.emplace_back(row.name, sds_of(with_prior_if_any(*row.estimate), terms));
  lines.emplace_back("reference", reference);
  std::vector<ColumnOf<Line>> columns{{"schedule", &Line::first}};
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const auto* parameter = find_parameter(chosen, terms[k]);
    const Unit unit = parameter ? parameter->unit : one;
    columns.emplace_back(terms[k], unit, [k, unit](const Line& line) { return number(line.second[k], unit); });
  }
  return tabulate("schedule_sd",
                  "standard uncertainty of every parameter; - if the schedule does not determine it; reference: the "
                  "value to which the criteria are relative",
                  lines, columns);
}

Table schedule_table(const Schedule& schedule) {
  Table table{"schedule", "the chosen segments, in order", {{"label", one}, {"duration", Unit::parse("s")}}, {}};
  for (const auto& segment : schedule)
    if (segment.run == schedule.front().run) table.rows.push_back({segment.label, segment.duration});
  return table;
}

/// Whether a finding says that one approach is not used, which is what approaches are for.
bool is_about_approach(const Finding& finding, const Schedule& schedule) {
  if (finding.code != "segment_not_used" || finding.occurrences.count != 1) return false;
  const auto* label = std::get_if<std::string>(&finding.values.front().value);
  return label && std::ranges::any_of(
                      schedule, [&](const Segment& segment) { return segment.approach && segment.label == *label; });
}

}  // namespace

Estimate described(const Plan& plan, const ScheduleRow& chosen, const std::vector<ScheduleRow>& rows,
                   const std::vector<std::string>& terms, const std::vector<double>& reference) {
  Estimate out = *chosen.estimate;
  out.title = (out.title.empty() ? plan.method : out.title) + ": " + chosen.name + " schedule";
  std::erase_if(out.findings, [&](const Finding& one) { return is_about_approach(one, chosen.schedule); });
  std::erase_if(out.tables, [](const Table& table) { return table.name != "prior"; });
  out.curves.clear();
  auto prior = std::move(out.tables);
  out.tables = {criteria_table(rows, terms, reference), sd_table(rows, out, terms, reference),
                schedule_table(chosen.schedule)};
  for (auto& table : prior) out.tables.push_back(std::move(table));
  return out;
}

}  // namespace tumble::optimisation
