#include "tumble/tasks/optimisation/report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/tasks/optimisation/criteria.hpp"
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

double total_of(const Schedule& schedule) {
  double sum = 0.0;
  for (const auto& segment : schedule) sum += segment.duration;
  return sum;
}

Table criteria_table(const std::vector<ScheduleRow>& rows, const std::vector<std::string>& terms,
                     const std::vector<double>& reference) {
  Table table{"schedules",
              "each in the same total time, except the plan as it is. det, trace, worst: uncertainty relative to the "
              "reference of each parameter as geometric mean over all directions, root mean square and largest; "
              "smaller is better",
              {{"schedule", one},
               {"segments", one},
               {"time", Unit::parse("min")},
               {"determined", one},
               {"det", one},
               {"trace", one},
               {"worst", one},
               {"condition", one},
               {"not distinguished", one}},
              {}};
  for (const auto& row : rows) {
    std::vector<Cell> cells{row.name, static_cast<double>(row.schedule.size()), total_of(row.schedule)};
    if (!row.estimate) {
      cells.insert(cells.end(), {"-", "-", "-", "-", "-", row.refused.text()});
      table.rows.push_back(std::move(cells));
      continue;
    }
    const auto criteria = criteria_of(with_prior_if_any(*row.estimate), terms, reference);
    std::vector<std::string> hidden;
    for (std::size_t k = 0; k < terms.size(); ++k)
      if (std::isinf(criteria.sd[k])) hidden.push_back(terms[k]);
    cells.insert(cells.end(), {fmt::format("{} of {}", terms.size() - hidden.size(), terms.size()),
                               number(criteria.determinant), number(criteria.trace), number(criteria.worst),
                               number(row.estimate->fit.condition), fmt::format("{}", fmt::join(hidden, ", "))});
    table.rows.push_back(std::move(cells));
  }
  return table;
}

Table sd_table(const std::vector<ScheduleRow>& rows, const Estimate& chosen, const std::vector<std::string>& terms,
               const std::vector<double>& reference) {
  Table table{"schedule_sd",
              "standard uncertainty of every parameter; - if the schedule does not determine it; reference: the value "
              "to which the criteria are relative",
              {{"schedule", one}},
              {}};
  for (const auto& term : terms) {
    const auto* parameter = find_parameter(chosen, term);
    table.columns.push_back({term, parameter ? parameter->unit : one});
  }
  const auto add = [&](const std::string& name, const std::vector<double>& sd) {
    std::vector<Cell> cells{name};
    for (std::size_t k = 0; k < terms.size(); ++k) cells.push_back(number(sd[k], table.columns[k + 1].unit));
    table.rows.push_back(std::move(cells));
  };
  for (const auto& row : rows)
    if (row.estimate) add(row.name, sds_of(with_prior_if_any(*row.estimate), terms));
  add("reference", reference);
  return table;
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
