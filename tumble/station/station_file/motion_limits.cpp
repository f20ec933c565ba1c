#include "tumble/station/station_file/motion_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/station/station_file/motion_extremes.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::station_file {

namespace {

using AxisKind = StationAxis::Kind;

Unit unit_of_place(AxisKind kind, bool difference) {
  if (kind == AxisKind::angle) return Unit::parse("deg");
  if (kind == AxisKind::acceleration) return Unit::parse("m/s^2");
  return Unit::parse(difference ? "K" : "degC");
}

/// Values of one axis against its limits. What is no number is beyond each.
class AxisLimits {
 public:
  AxisLimits(const StationAxis& axis, Sentence where) : axis_(axis), where_(std::move(where)) {}

  void place(double value) {
    const double rounding = 1e-12 * (1.0 + std::abs(value));
    if (axis_.lowest && !(value >= *axis_.lowest - rounding)) beyond(value, *axis_.lowest, point_);
    if (axis_.highest && !(value <= *axis_.highest + rounding)) beyond(value, *axis_.highest, point_);
  }
  void travel(double value) {
    if (axis_.lowest && axis_.highest && !(value <= *axis_.highest - *axis_.lowest))
      beyond(value, *axis_.highest - *axis_.lowest, unit_of_place(axis_.kind, true));
  }
  void rate(double value) {
    const Unit unit = Unit::parse(axis_.kind == AxisKind::temperature ? "K/min"
                                  : axis_.kind == AxisKind::angle     ? "deg/s"
                                                                      : "m/s^3");
    if (axis_.max_rate && !(std::abs(value) <= *axis_.max_rate * (1.0 + 1e-9))) beyond(value, *axis_.max_rate, unit);
  }
  void acceleration(double value, double crest) {
    const Unit unit = Unit::parse(axis_.kind == AxisKind::temperature ? "K/s^2"
                                  : axis_.kind == AxisKind::angle     ? "deg/s^2"
                                                                      : "m/s^2");
    if (axis_.max_acceleration && !(value <= *axis_.max_acceleration * (1.0 + 1e-9)))
      beyond(value, *axis_.max_acceleration, unit, crest);
  }

  Problems problems;

 private:
  void beyond(double value, double limit, const Unit& unit, double crest = 1.0) {
    const Sentence peaks = crest == 1.0
                               ? Sentence()
                               : say(" in its peaks, {:.3g} standard deviations{},", crest,
                                     axis_.clips_at ? "" : " (if the drive clips them, state `clips_at` of the axis)");
    problems.push_back(say("{}{}: {:.6g} {}{} is beyond the station's {:.6g} {}", where_, Name{axis_.name},
                           unit.from_si(value), Name{unit.text()}, peaks, unit.from_si(limit), Name{unit.text()}));
  }

  const StationAxis& axis_;
  Sentence where_;
  Unit point_ = unit_of_place(axis_.kind, false);
};

}  // namespace

Problems beyond_limits(const Segment& segment, const StationAxis& axis, const Motion& motion,
                       std::optional<double> stands_at) {
  AxisLimits limits(axis, say("segment '{}': ", segment.label));
  // A motion goes on while the axis settles and soaks, and for the duration.
  const double seconds = axis.settle.hold + axis.settle.soak + segment.duration;
  const MotionExtremes extremes = extremes_of(motion, seconds, axis.clips_at);
  if (axis.kind == AxisKind::acceleration) stands_at = 0.0;
  const auto from = extremes.place ? extremes.place : stands_at;
  limits.travel(extremes.highest - extremes.lowest);
  if (from && extremes.lowest < 0.0) limits.place(*from + extremes.lowest);
  if (from && !(extremes.lowest < 0.0 && extremes.highest <= 0.0)) limits.place(*from + extremes.highest);
  if (axis.kind == AxisKind::acceleration) {
    const double base = extremes.place.value_or(0.0);
    limits.acceleration(std::max(std::abs(base + extremes.lowest), std::abs(base + extremes.highest)), extremes.crest);
    return std::move(limits.problems);
  }
  limits.rate(extremes.rate);
  limits.acceleration(extremes.acceleration, extremes.crest);
  return std::move(limits.problems);
}

Problems beyond_limits_of_safe(const StationAxis& axis, double temperature) {
  AxisLimits limits(axis, "");
  limits.place(axis.sign * temperature + axis.offset);
  return std::move(limits.problems);
}

}  // namespace tumble::station_file
