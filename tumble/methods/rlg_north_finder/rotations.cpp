#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"
#include "tumble/methods/rlg_north_finder/faults.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::rlg_north_finder {
namespace {

using Severity = Finding::Severity;
using Segments = std::span<const linear::SegmentSummary>;
constexpr double beyond_chance = 6.0;
constexpr const char* axes[] = {"x", "y", "z"};

/// The scale factor that the Earth's rate gives at rest, with what the rests scatter about it.
struct AtRest {
  double scale = 0.0, sd = INFINITY;
};

AtRest at_rest(Segments segments) {
  double n = 0.0, w = 0.0, y = 0.0, ww = 0.0, wy = 0.0;
  for (const auto& one : segments)
    if (one.steady) n += 1.0, w += one.felt.rate.x, y += one.measured;
  if (n < 4.0) return {};
  for (const auto& one : segments)
    if (one.steady) {
      ww += (one.felt.rate.x - w / n) * (one.felt.rate.x - w / n);
      wy += (one.felt.rate.x - w / n) * (one.measured - y / n);
    }
  if (!(ww > 0.0)) return {};
  AtRest found{wy / ww, 0.0};
  double squares = 0.0;
  for (const auto& one : segments)
    if (one.steady) squares += std::pow(one.measured - y / n - found.scale * (one.felt.rate.x - w / n), 2);
  found.sd = std::sqrt(squares / (n - 2.0) / ww);
  return found;
}

/// Too few turns, and the wrong sense, are seen by the Earth's rate alone.
void against_earth(Segments segments, const Path& path, double scale, Findings& findings) {
  const AtRest rest = at_rest(segments);
  const Turning* forward = path.rotation(0, true);
  if (forward == nullptr || !(std::abs(rest.scale) > beyond_chance * rest.sd)) return;
  if (rest.scale * scale < 0.0) {
    findings.push_back({Severity::error,
                        fmt::format("the rotations about x ran in the other sense than the plan says: by them the "
                                    "scale factor is {}, by the Earth's rate at rest {}",
                                    say_difference(scale, Unit::parse("pulse/arcsec")),
                                    say_difference(rest.scale, Unit::parse("pulse/arcsec"))),
                        segments[forward->segment].label});
    return;
  }
  const double turns = std::round(std::abs(forward->turns)), seen = turns * scale / rest.scale;
  const double sd = seen * rest.sd / std::abs(rest.scale);
  if (std::abs(seen - turns) > beyond_chance * sd && std::abs(seen - turns) > 0.2)
    findings.push_back(
        {Severity::error,
         fmt::format("the rotations about x do not fit the Earth's rate seen at rest: the plan says {:.0f} turns, the "
                     "counts look like {:.1f} +- {:.1f}; count the turns, or look for wrong positions",
                     turns, seen, sd),
         segments[forward->segment].label});
  if (scale < 0.0)
    findings.push_back({Severity::warning,
                        "the gyro counts down where it turns forward: its scale factor is negative, at rest as well",
                        ""});
}

/// Forward and reverse of an axis must give the same magnitude.
void both_ways(Segments segments, const Path& path, const Estimate& estimate, Findings& findings) {
  const double scale = estimate.parameters[0].value, bias = estimate.parameters[1].value;
  const Turning *forward = path.rotation(0, true), *reverse = path.rotation(0, false);
  if (!forward || !reverse || scale * at_rest(segments).scale < 0.0) return;  // the other sense is said already
  const auto turned = [&](const Turning& one) {
    const auto& segment = segments[one.segment];
    const double earth = segment.felt.rate.x * segment.duration - two_pi * std::round(one.turns);
    return segment.measured * segment.duration / scale - bias * segment.duration - earth;
  };
  const double difference = std::abs(turned(*forward)) - std::abs(turned(*reverse));
  const double least = std::max(si(0.05, "deg"), beyond_chance * segments[forward->segment].sd *
                                                     segments[forward->segment].duration / std::abs(scale));
  if (std::abs(difference) > least)
    findings.push_back(
        {Severity::error,
         fmt::format(
             "the turns about x are not whole, or not the same both ways: the counts of '{}' and '{}' differ by "
             "{} of angle: begin and end each rotation at the same mark",
             segments[forward->segment].label, segments[reverse->segment].label,
             say_difference(std::abs(difference), Unit::parse("deg"))),
         ""});
}

void unequal_times(Segments segments, const Path& path, const Estimate& estimate, Findings& findings, bool closed) {
  for (int axis = 0; axis < 3; ++axis) {
    const Turning *forward = path.rotation(axis, true), *reverse = path.rotation(axis, false);
    if (!forward || !reverse) continue;
    const double apart = forward->seconds - reverse->seconds;
    if (std::abs(apart) < 1e-3 * forward->seconds) continue;
    // what the gyro shows besides the rotation, on average over it
    const auto &f = segments[forward->segment], &r = segments[reverse->segment];
    const double rest = estimate.parameters[1].value + 0.5 * (f.felt.rate.x + r.felt.rate.x);
    const double leak = apart * rest / (two_pi * (std::round(forward->turns) - std::round(reverse->turns)));
    const std::string what =
        axis == 0 ? fmt::format("{:.2g} ppm of the scale factor", 1e6 * leak)
                  : fmt::format("{} of gyro.misalignment_{}", say_difference(leak, Unit::parse("arcsec")), axes[axis]);
    findings.push_back({closed ? Severity::warning : Severity::info,
                        fmt::format("the rotations about {} took {} forward and {} reverse: the Earth's rate and the "
                                    "bias add {} to the formulas{}",
                                    axes[axis], say_seconds(forward->seconds), say_seconds(reverse->seconds), what,
                                    closed ? "; least_squares takes it into account" : ", not to least_squares"),
                        ""});
  }
}

/// The rate at which an axis is told to turn in a segment.
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
  for (const auto& one : path.rotations) {
    const double rate = commanded_rate(plan, segments[one.segment]);
    const double off = std::abs(std::remainder(rate, spacing));
    if (one.axis != 0 || off > near) continue;
    findings.push_back(
        {Severity::warning,
         fmt::format(
             "{} is within {} of a multiple of dither frequency over scale factor ({}), where lock-in acts on a "
             "turning gyro too: turn at another rate, or at several",
             say_difference(rate, Unit::parse("deg/s")), say_difference(off, Unit::parse("deg/s")),
             say_difference(spacing, Unit::parse("deg/s"))),
         segments[one.segment].label});
  }
}

}  // namespace

Findings rotation_faults(const Plan& plan, const Summaries& segments, const Estimate& estimate) {
  Findings findings;
  const Settings& settings = plan.settings;
  const Segments of_gyro = segments[gyro];
  const Path path = path_of({of_gyro.begin(), of_gyro.end()});
  const double scale = estimate.parameters[0].value;
  against_earth(of_gyro, path, scale, findings);
  both_ways(of_gyro, path, estimate, findings);
  unequal_times(of_gyro, path, estimate, findings, settings.word("estimator") == "closed_form");
  if (settings.has("dither_frequency")) near_multiples(plan, of_gyro, path, scale, findings);
  return findings;
}

}  // namespace tumble::rlg_north_finder
