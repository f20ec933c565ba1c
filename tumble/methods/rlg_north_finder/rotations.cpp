#include <algorithm>
#include <cmath>

#include "tumble/methods/rlg_north_finder/faults.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::rlg_north_finder {
namespace {

using Severity = Finding::Severity;
using Segments = std::span<const linear::SegmentSummary>;
constexpr double fewest_stays = 4.0;        ///< for scale factor and bias at rest, and degrees of freedom
constexpr double turns_apart = 0.2;         ///< [turns] a wrong number of turns is at least a half off
constexpr double least_angle_apart = 0.05;  ///< [deg] between two rotations: stops and clocks of any table are better
/// [arcsec] between two rotations whose angles were recorded: what encoders and the Earth on the way leave.
constexpr double least_of_recorded = 10.0;
constexpr double unequal_time = 1e-3;  ///< [1] of the time of a rotation

constexpr double significant = 6.0;  ///< standard deviations

/// Scale factor by the Earth's rate at rest, and its standard deviation by the scatter of the rests.
struct AtRest {
  double scale = 0.0, sd = INFINITY;
};

AtRest at_rest(Segments segments) {
  double n = 0.0, w = 0.0, y = 0.0, ww = 0.0, wy = 0.0;
  for (const auto& segment : segments)
    if (segment.steady) n += 1.0, w += segment.felt.rate.x, y += segment.measured;
  if (n < fewest_stays) return {};
  for (const auto& segment : segments)
    if (segment.steady) {
      ww += (segment.felt.rate.x - w / n) * (segment.felt.rate.x - w / n);
      wy += (segment.felt.rate.x - w / n) * (segment.measured - y / n);
    }
  if (!(ww > 0.0)) return {};
  const double scale = wy / ww;
  double squares = 0.0;
  for (const auto& segment : segments)
    if (segment.steady) squares += std::pow(segment.measured - y / n - scale * (segment.felt.rate.x - w / n), 2);
  return {scale, std::sqrt(squares / (n - 2.0) / ww)};
}

/// Too few turns, and the wrong sense: the Earth's rate alone shows them.
void against_earth(Segments segments, const Path& path, double scale, Findings& findings) {
  const AtRest rest = at_rest(segments);
  const Turning* forward = path.rotation(0, true);
  if (forward == nullptr || !(std::abs(rest.scale) > significant * rest.sd)) return;
  const std::string& label = segments[forward->segment].label;
  if (rest.scale * scale < 0.0) {
    findings.push_back({Severity::error,
                        "rotation_reversed_by_scale_factor",
                        {{"by_rotations", scale, "pulse/arcsec"}, {"at_rest", rest.scale, "pulse/arcsec"}},
                        label});
    return;
  }
  const double turns = std::round(std::abs(forward->turns)), counted = turns * scale / rest.scale;
  const double sd = counted * rest.sd / std::abs(rest.scale);
  if (std::abs(counted - turns) > significant * sd && std::abs(counted - turns) > turns_apart)
    findings.push_back({Severity::error,
                        "turns_do_not_fit_earth_rate",
                        {{"planned", turns}, {"counted", counted}, {"sd", sd}},
                        label});
  if (scale < 0.0) findings.push_back({Severity::error, "gyro_counts_down", {}});
}

/// Forward and reverse of an axis must give the same magnitude.
void both_ways(Segments segments, const Path& path, const Estimate& estimate, bool recorded, Findings& findings) {
  const double scale = estimate.parameters[0].value, bias = estimate.parameters[1].value;
  const Turning *forward = path.rotation(0, true), *reverse = path.rotation(0, false);
  if (!forward || !reverse || scale * at_rest(segments).scale < 0.0) return;  // the finding of the other sense says it
  const auto turned = [&](const Turning& turning) {
    const auto& segment = segments[turning.segment];
    const double earth = segment.felt.rate.x * segment.duration - two_pi * std::round(turning.turns);
    return segment.measured * segment.duration / scale - bias * segment.duration - earth;
  };
  const double difference = std::abs(turned(*forward)) - std::abs(turned(*reverse));
  double variance = 0.0;
  for (const Turning* turning : {forward, reverse})
    variance += std::pow(segments[turning->segment].sd * turning->seconds / scale, 2);
  const double least = std::max(recorded ? si(least_of_recorded, "arcsec") : si(least_angle_apart, "deg"),
                                significant * std::sqrt(variance));
  if (std::abs(difference) > least)
    findings.push_back({Severity::error,
                        "forward_and_reverse_differ",
                        {{"forward", segments[forward->segment].label},
                         {"reverse", segments[reverse->segment].label},
                         {"difference", std::abs(difference), "deg"}}});
}

void unequal_times(Segments segments, const Path& path, const Estimate& estimate, Findings& findings, bool closed) {
  for (int axis = 0; axis < 3; ++axis) {
    const Turning *forward = path.rotation(axis, true), *reverse = path.rotation(axis, false);
    if (!forward || !reverse) continue;
    const double apart = forward->seconds - reverse->seconds;
    if (std::abs(apart) < unequal_time * forward->seconds) continue;
    // output of the gyro without the rotation, on average over it
    const auto &f = segments[forward->segment], &r = segments[reverse->segment];
    const double rest = estimate.parameters[1].value + 0.5 * (f.felt.rate.x + r.felt.rate.x);
    const double leak = apart * rest / (two_pi * (std::round(forward->turns) - std::round(reverse->turns)));
    const std::string parameter =
        axis == 0 ? "gyro.scale_factor" : std::string("gyro.misalignment_") + axis_names[axis];
    findings.push_back({closed ? Severity::warning : Severity::info,
                        closed ? "unequal_times_in_formulas" : "unequal_times",
                        {{"axis", axis_names[axis]},
                         {"forward", forward->seconds, "s"},
                         {"reverse", reverse->seconds, "s"},
                         {"leak", leak, axis == 0 ? "ppm" : "arcsec"},
                         {"parameter", parameter}}});
  }
}

/// Commanded rate of the axis that turns in a segment [rad/s].
double commanded_rate(const Plan& plan, const linear::SegmentSummary& summary) {
  double rate = 0.0;
  for (const auto& segment : plan.schedule)
    if (segment.label == summary.label && segment.run == summary.run)
      for (const auto& [axis, motion] : segment.axes)
        if (motion.kind == Motion::Kind::slew || motion.kind == Motion::Kind::rate)
          rate = std::max(rate, std::abs(motion.value));
  return rate;
}

void near_multiples(const Plan& plan, Segments segments, const Path& path, double scale, Findings& findings) {
  const double near = si(0.02, "deg/s");
  const double spacing = plan.settings.number("dither_frequency") / std::abs(scale);
  Occurrences rotations{0, {}, {}};
  double rate = 0.0, nearest = near;
  for (const auto& turning : path.rotations) {
    const auto& segment = segments[turning.segment];
    const double commanded = commanded_rate(plan, segment);
    const double off = std::abs(std::remainder(commanded, spacing));
    if (turning.axis != 0 || off > near) continue;
    if (rotations.count++ == 0) rotations.first = segment.label;
    if (rotations.worst.given() && off >= nearest) continue;
    rotations.worst = segment.label, rate = commanded, nearest = off;
  }
  if (rotations.count > 0)
    findings.push_back({Severity::warning,
                        "rate_near_dither_multiple",
                        {{"rate", rate, "deg/s"}, {"difference", nearest, "deg/s"}, {"spacing", spacing, "deg/s"}},
                        "",
                        rotations});
}

}  // namespace

Findings rotation_faults(const Plan& plan, const Summaries& segments, const Estimate& estimate, bool recorded) {
  Findings findings;
  const Settings& settings = plan.settings;
  const Segments of_gyro = segments[gyro];
  const Path path = path_of({of_gyro.begin(), of_gyro.end()});
  const double scale = estimate.parameters[0].value;
  against_earth(of_gyro, path, scale, findings);
  both_ways(of_gyro, path, estimate, recorded, findings);
  unequal_times(of_gyro, path, estimate, findings, settings.word("estimator") == "closed_form");
  if (settings.has("dither_frequency")) near_multiples(plan, of_gyro, path, scale, findings);
  return findings;
}

}  // namespace tumble::rlg_north_finder
