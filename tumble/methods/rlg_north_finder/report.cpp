#include "tumble/methods/rlg_north_finder/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/rigs/rig.hpp"

namespace tumble::rlg_north_finder {
namespace {

/// Axes of the rig that the schedule turns.
std::vector<std::string> axes_of(const Plan& plan) {
  std::vector<std::string> axes;
  for (const auto& axis : find_rig(plan.rig_kind).axes()) {
    const bool used =
        std::ranges::any_of(plan.schedule, [&](const Segment& segment) { return segment.axes.contains(axis.name); });
    if (used && !is_mount_axis(axis.name) && axis.unit == "deg") axes.push_back(axis.name);
  }
  return axes;
}

const linear::SegmentSummary* find(std::span<const linear::SegmentSummary> segments,
                                   const linear::SegmentSummary& like) {
  for (const auto& segment : segments)
    if (segment.label == like.label && segment.run == like.run &&
        std::abs(segment.begin - like.begin) < 1.0 + like.duration)
      return &segment;
  return nullptr;
}

/// Value of an option of the rig, 0 where the rig lacks it or is ideal.
double stated(const Settings& rig, const char* name) {
  return rig.texts().contains(name) && !rig.flag("ideal") ? rig.number(name) : 0.0;
}

/// Angles [rad] that the plan commands in the segment; NaN where the plan lacks it.
void append_angles(const Schedule& schedule, const std::vector<std::vector<double>>& angles,
                   const linear::SegmentSummary& segment, std::vector<Table::Cell>& row) {
  const auto planned = std::ranges::find_if(
      schedule, [&](const Segment& some) { return some.label == segment.label && some.run == segment.run; });
  const auto number = static_cast<std::size_t>(planned - schedule.begin());
  for (const auto& of_axis : angles) row.emplace_back(planned == schedule.end() ? std::nan("") : of_axis[number]);
}

/// Counts of one output: as measured, predicted, their difference; without recordings predicted alone.
void append_counts(const linear::SegmentSummary& segment, bool measured, std::vector<Table::Cell>& row) {
  if (measured) row.emplace_back(segment.measured * segment.duration);
  row.emplace_back(segment.predicted * segment.duration);
  if (measured) row.emplace_back((segment.measured - segment.predicted) * segment.duration);
}

struct Tilt {
  const char* name;
  const char* description;
  double value = 0.0, prior = 0.0;
};

std::array<Tilt, 3> list_of(const Tilts& tilts, const Settings& rig) {
  const double level = stated(rig, "level_sd"), zero = stated(rig, "index_zero_sd");
  return {{{"rho_X", "tilt of the base about X (Y along the outer axis, Z up)", tilts.rho_x, level},
           {"rho_Y", "tilt about the outer axis, or its zero", tilts.rho_y, std::hypot(level, zero)},
           {"eta", "inner axis towards the outer one", tilts.eta, stated(rig, "orthogonality_sd")}}};
}

}  // namespace

Table positions_table(const Plan& plan, const Summaries& segments) {
  const Unit pulse = Unit::parse("pulse");
  const bool measured = std::ranges::none_of(segments[gyro], [](const auto& s) { return std::isnan(s.measured); });
  Table table{"positions",
              "counts of each stay and rotation over the time used; predicted without what rig_errors lists",
              {{"label", Unit()}},
              {}};
  std::vector<std::vector<double>> angles;
  for (const auto& axis : axes_of(plan)) {
    table.columns.push_back({axis, Unit::parse("deg")});
    angles.push_back(table::commands_of(plan.schedule, axis));
  }
  table.columns.push_back({"duration", Unit::parse("s")});
  for (const Which output : {gyro, accelerometer_x, accelerometer_y})
    for (const char* column : {"", "_predicted", "_residual"})
      if (measured || std::string(column) == "_predicted")
        table.columns.push_back({std::string(role_of(output)) + column, pulse});
  for (const auto& segment : segments[gyro]) {
    std::vector<Table::Cell> row{segment.label};
    append_angles(plan.schedule, angles, segment, row);
    row.emplace_back(segment.duration);
    append_counts(segment, measured, row);
    for (const Which output : {accelerometer_x, accelerometer_y})
      if (const auto* match = find(segments[output], segment))
        append_counts(*match, measured, row);
      else
        row.insert(row.end(), measured ? 3 : 1, std::string());
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table estimators_table(const std::vector<double>& least_squares, const std::vector<double>& closed_form,
                       const Estimate& estimate) {
  // every row has a unit of its own, so that the columns are text
  Table table{
      "estimators",
      "all together with the errors of the table, and the formulas (2.1)-(2.7), which take the table as perfect",
      {{"parameter", Unit()},
       {"unit", Unit()},
       {"least_squares", Unit()},
       {"closed_form", Unit()},
       {"difference", Unit()},
       {"sd", Unit()}},
      {}};
  for (std::size_t p = 0; p < wanted().size(); ++p) {
    const Unit unit = Unit::parse(wanted()[p].unit);
    const auto shown = [&](double value) { return fmt::format("{:.6g}", unit.difference_from_si(value)); };
    table.rows.push_back({wanted()[p].name, wanted()[p].unit, shown(least_squares[p]), shown(closed_form[p]),
                          fmt::format("{:.2g}", unit.difference_from_si(least_squares[p] - closed_form[p])),
                          fmt::format("{:.2g}", unit.difference_from_si(standard_uncertainty(estimate, p)))});
  }
  return table;
}

Table tilts_table(const Tilts& tilts, const Settings& rig) {
  const Unit arcsec = Unit::parse("arcsec");
  Table table{"table_errors",
              "what the accelerometers show of the table with z up and down (2.19), and what the rig states",
              {{"error", Unit()}, {"description", Unit()}, {"value", arcsec}, {"sd", arcsec}, {"stated", arcsec}},
              {}};
  if (!tilts.known) return table;
  for (const auto& tilt : list_of(tilts, rig))
    table.rows.push_back({tilt.name, tilt.description, tilt.value, tilts.sd, tilt.prior});
  return table;
}

Findings tilt_faults(const Tilts& tilts, const Settings& rig) {
  Findings findings;
  if (!tilts.known) return findings;
  for (const auto& tilt : list_of(tilts, rig))
    if (std::abs(tilt.value) > 4.0 * std::hypot(tilt.prior, tilts.sd) && tilt.prior > 0.0)
      findings.push_back({Finding::Severity::error,
                          "tilt_beyond_rig",
                          {{"tilt", tilt.name}, {"value", tilt.value, "arcsec"}, {"stated", tilt.prior, "arcsec"}}});
  return findings;
}

}  // namespace tumble::rlg_north_finder
