#include "tumble/methods/rlg_north_finder/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble::rlg_north_finder {
namespace {

constexpr double tilt_beyond_sd = 4.0;  ///< [sd] of tilt and prior: p = 6e-5
constexpr double lost_sd = 3.0;         ///< [sd] of a scale factor, that the cosine of a misalignment takes from it

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

/// Angle [rad] of an axis that the plan commands in the segment; NaN where the plan lacks it.
double angle_in(const Schedule& schedule, const std::vector<double>& of_axis, const linear::SegmentSummary& segment) {
  const auto planned = std::ranges::find_if(
      schedule, [&](const Segment& some) { return some.label == segment.label && some.run == segment.run; });
  return planned == schedule.end() ? std::nan("") : of_axis[static_cast<std::size_t>(planned - schedule.begin())];
}

/// Columns with the counts of one output: as measured, predicted, their difference; without recordings predicted alone.
void add_counts(const Summaries& segments, Which output, bool measured,
                std::vector<ColumnOf<linear::SegmentSummary>>& columns) {
  using Summary = linear::SegmentSummary;
  const auto count = [&segments, output](auto of) {
    return [of, &segments, output](const Summary& segment) {
      const Summary* match = output == gyro ? &segment : find(segments[output], segment);
      return match ? Table::Cell(of(*match) * match->duration) : "";
    };
  };
  const std::string role = role_of(output);
  if (measured) columns.emplace_back(role, "pulse", count([](const Summary& s) { return s.measured; }));
  columns.emplace_back(role + "_predicted", "pulse", count([](const Summary& s) { return s.predicted; }));
  if (measured)
    columns.emplace_back(role + "_residual", "pulse", count([](const Summary& s) { return s.measured - s.predicted; }));
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
  using Summary = linear::SegmentSummary;
  const bool measured = std::ranges::none_of(segments[gyro], [](const auto& s) { return std::isnan(s.measured); });
  std::vector<ColumnOf<Summary>> columns{{"label", &Summary::label}};
  for (const auto& axis : axes_of(plan))
    columns.emplace_back(axis, "deg", [&plan, angles = table::commands_of(plan.schedule, axis)](const Summary& s) {
      return angle_in(plan.schedule, angles, s);
    });
  columns.emplace_back("duration", "s", &Summary::duration);
  for (const Which output : {gyro, accelerometer_x, accelerometer_y}) add_counts(segments, output, measured, columns);
  return tabulate("positions",
                  "counts of each stay and rotation over the time used; predicted without what rig_errors lists",
                  segments[gyro], columns);
}

Table estimators_table(const std::vector<double>& least_squares, const std::vector<double>& closed_form,
                       const Estimate& estimate) {
  // every row has a unit of its own, so that the columns are text
  const auto text = [](std::size_t p, double value, int digits) {
    return fmt::format("{:.{}g}", Unit::parse(wanted()[p].unit).difference_from_si(value), digits);
  };
  return tabulate(
      "estimators",
      "all together with the errors of the table, and the formulas (2.1)-(2.7), which take the table as perfect",
      wanted().size(),
      {{"parameter", [](std::size_t p) { return wanted()[p].name; }},
       {"unit", [](std::size_t p) { return wanted()[p].unit; }},
       {"least_squares", [&](std::size_t p) { return text(p, least_squares[p], 6); }},
       {"closed_form", [&](std::size_t p) { return text(p, closed_form[p], 6); }},
       {"difference", [&](std::size_t p) { return text(p, least_squares[p] - closed_form[p], 2); }},
       {"sd", [&](std::size_t p) { return text(p, standard_uncertainty(estimate, p), 2); }}});
}

Table tilts_table(const Tilts& tilts, const Settings& rig) {
  std::vector<Tilt> rows;
  if (tilts.known) std::ranges::copy(list_of(tilts, rig), std::back_inserter(rows));
  return tabulate("table_errors",
                  "what the accelerometers show of the table with z up and down (2.19), and what the rig states", rows,
                  {{"error", &Tilt::name},
                   {"description", &Tilt::description},
                   {"value", "arcsec", &Tilt::value},
                   {"sd", "arcsec", [&](const Tilt&) { return tilts.sd; }},
                   {"stated", "arcsec", &Tilt::prior}});
}

Findings tilt_faults(const Tilts& tilts, const Settings& rig) {
  Findings findings;
  if (!tilts.known) return findings;
  for (const auto& tilt : list_of(tilts, rig))
    if (std::abs(tilt.value) > tilt_beyond_sd * std::hypot(tilt.prior, tilts.sd) && tilt.prior > 0.0)
      findings.push_back({Finding::Severity::error,
                          "tilt_beyond_rig",
                          {{"tilt", tilt.name}, {"value", tilt.value, "arcsec"}, {"stated", tilt.prior, "arcsec"}}});
  return findings;
}

Findings mounting_faults(const Estimate& estimate) {
  Findings findings;
  for (std::size_t p = 0; p < wanted().size(); ++p) {
    if (p % per_output < 2) continue;  // the scale factor and the bias
    const std::string scale_factor = wanted()[p / per_output * per_output].name;
    const Parameter *angle = find_parameter(estimate, wanted()[p].name),
                    *scale = find_parameter(estimate, scale_factor);
    if (angle == nullptr || scale == nullptr) continue;
    const double lost = 0.5 * angle->value * angle->value;
    const auto j = static_cast<std::size_t>(scale - estimate.parameters.data());
    if (lost > lost_sd * standard_uncertainty(estimate, j) / std::abs(scale->value))
      findings.push_back({Finding::Severity::error,
                          "misalignment_changes_scale_factor",
                          {{"parameter", wanted()[p].name}, {"angle", angle->value, "deg"}, {"lost", lost, "ppm"}},
                          scale_factor});
  }
  return findings;
}

}  // namespace tumble::rlg_north_finder
