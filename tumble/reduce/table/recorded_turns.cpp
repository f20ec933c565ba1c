#include "tumble/reduce/table/recorded_turns.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <optional>
#include <utility>

#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/reduce/table/encoders.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::table {
namespace {

using Kind = Motion::Kind;

constexpr double least_tolerance = 0.1 * degree;  ///< [rad], 0.1 deg
constexpr double most_tolerance = 0.5;            ///< [rad]
constexpr double explained = 6.0;                 ///< standard deviations of what a rig does otherwise than its plan
constexpr double least_resultant = 0.9;           ///< of residuals of 26 deg rms
constexpr double amplitude_tolerance = 0.2;
constexpr double most_rate_departure = 0.01;  ///< [1] of the rate commanded; beyond it another motion was recorded

bool turns_or_oscillates(const Motion* motion) {
  return motion != nullptr && !motion->continued &&
         ((motion->kind == Kind::rate && motion->value != 0.0) ||
          (motion->kind == Kind::sine && motion->amplitude != 0.0));
}

/// Angles [rad] at times [s] since the beginning of a segment.
struct Angles {
  std::vector<double> times, values;
};

/// Where a motion is, by angles.
struct Phase {
  double from = 0.0;               ///< [rad]
  double known_at = 0.0;           ///< rate: mean time of the readings [s since the beginning of the segment]
  std::complex<double> wave = {};  ///< sine: amplitude exp(j phase) by that of the plan; 1 if it is as planned
};

std::optional<Phase> phase_of_rate(double rate, const Angles& angles) {
  std::complex<double> sum;
  double times = 0.0;
  for (std::size_t i = 0; i < angles.times.size(); ++i) {
    sum += std::polar(1.0, angles.values[i] - rate * angles.times[i]);
    times += angles.times[i];
  }
  const auto count = static_cast<double>(angles.times.size());
  if (angles.times.empty() || std::abs(sum) < least_resultant * count) return {};
  return Phase{std::arg(sum), times / count, {}};
}

/// Readings without the jumps of a turn.
std::vector<double> unwrapped(std::vector<double> values) {
  for (std::size_t i = 1; i < values.size(); ++i)
    values[i] = values[i - 1] + std::remainder(values[i] - values[i - 1], two_pi);
  return values;
}

std::optional<Phase> phase_of_sine(const Motion& motion, const Angles& angles) try {
  const SineFit fit = fit_sine(angles.times, unwrapped(angles.values), motion.frequency, {.polynomial = 0});
  constexpr std::complex<double> j(0.0, 1.0);
  const std::complex<double> wave =
      j * fit.line[0] * std::polar(1.0, -two_pi * motion.frequency * fit.centre) / motion.amplitude;
  if (std::abs(std::abs(wave) - 1.0) > amplitude_tolerance) return {};
  return Phase{fit.polynomial[0], 0.0, wave / std::abs(wave)};
} catch (const Error& error) {
  if (error.kind != Error::Kind::bad_data) throw;
  return {};
}

/// By how much an axis turns at another rate than commanded, with its standard deviation from the scatter of the
/// readings about the line [rad/s].
struct RateDeparture {
  double rate = 0.0, sd = 0.0;
};

/// The slope of `residuals` over the times of the same indices, begin <= i < end.
RateDeparture slope_of(const Angles& angles, const std::vector<double>& residuals, std::size_t begin, std::size_t end) {
  const auto count = static_cast<double>(end - begin);
  double mean_t = 0.0, mean_x = 0.0, tt = 0.0, tx = 0.0, xx = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    mean_t += angles.times[i] / count;
    mean_x += residuals[i] / count;
  }
  for (std::size_t i = begin; i < end; ++i) {
    const double t = angles.times[i] - mean_t, x = residuals[i] - mean_x;
    tt += t * t;
    tx += t * x;
    xx += x * x;
  }
  const double slope = tx / tt;
  return {slope, std::sqrt(std::max(xx - slope * tx, 0.0) / (count - 2.0) / tt)};
}

/// The slope of angle - W t; nothing where the readings are too few, or where both halves of the time disagree by more
/// than `tolerance` [rad/s] and their scatter explain: an axis that still comes to its rate has none.
std::optional<RateDeparture> departure_of_rate(double rate, const Angles& angles, double tolerance) {
  constexpr std::size_t least = 10;
  const std::size_t count = angles.times.size();
  if (count < least) return {};
  std::vector<double> residuals;
  for (std::size_t i = 0; i < count; ++i) residuals.push_back(angles.values[i] - rate * angles.times[i]);
  residuals = unwrapped(std::move(residuals));
  const auto all = slope_of(angles, residuals, 0, count), first = slope_of(angles, residuals, 0, count / 2),
             second = slope_of(angles, residuals, count / 2, count);
  if (std::abs(first.rate - second.rate) > tolerance + explained * std::hypot(first.sd, second.sd)) return {};
  if (std::abs(all.rate) > most_rate_departure * std::abs(rate)) return {};
  // An encoder that resolves little shows one step in an hour: such a step is a slope of up to 1.5 step/time.
  double step = 0.0;
  for (std::size_t i = 1; i < count; ++i) step = std::max(step, std::abs(residuals[i] - residuals[i - 1]));
  return RateDeparture{all.rate, std::max(all.sd, 0.5 * step / (angles.times.back() - angles.times.front()))};
}

/// What the axis turned faster than the plan says [rad/s], where neither the plan's error of the rate nor the readings
/// explain it; else 0.
double excess_rate(const Plan& plan, const Motion& motion, const Angles& readings) {
  if (motion.kind != Kind::rate) return 0.0;
  const double planned = plan.rig.has("rate_error_sd") ? plan.rig.number("rate_error_sd") * motion.value : 0.0;
  const auto departure = departure_of_rate(motion.value, readings, explained * std::abs(planned));
  if (!departure) return 0.0;
  const double expected = explained * std::hypot(planned, departure->sd);
  return std::abs(departure->rate) > expected ? departure->rate : 0.0;
}

std::optional<Phase> phase_of(const Motion& motion, const Angles& angles) {
  return motion.kind == Kind::rate ? phase_of_rate(motion.value, angles) : phase_of_sine(motion, angles);
}

/// The readings of a segment whose samples lie in it wholly.
Angles readings_in(const Channel& channel, const PlacedSegment& place) {
  const double step = 1.0 / mean_rate(channel), slack = stamp_slack(place.end, step);
  Angles out;
  for (std::size_t i = index_at(channel, place.settled - slack);
       i < channel.values.size() && channel.time(i) + step < place.end + slack; ++i) {
    if (std::isnan(channel.values[i])) continue;
    out.times.push_back(channel.time(i) + 0.5 * step - place.begin);
    out.values.push_back(channel.values[i]);
  }
  return out;
}

/// The schedule of a plan as its rig carries it out, without errors.
struct Course {
  std::vector<PowerUp> power_ups;
  std::vector<std::pair<std::size_t, std::size_t>> places;  ///< power-up and segment, of each segment of the schedule

  /// What the drive of an axis shows, or nothing.
  std::optional<Angles> planned(std::size_t segment, const std::string& axis, const std::vector<double>& times) const {
    const auto& [power_up, number] = places[segment];
    const auto& drives = power_ups[power_up].reference.drives;
    const auto drive = std::ranges::find(drives, axis, &Drive::axis);
    if (drive == drives.end()) return {};
    Angles out{times, {}};
    for (const double time : times) out.values.push_back(drive->at(power_ups[power_up].begins[number] + time).value);
    return out;
  }
};

Course course_of(const Plan& plan, bool alone) {
  Course course;
  if (!alone) course.power_ups = power_ups_of(plan, 1.0);
  for (std::size_t s = 0; alone && s < plan.schedule.size(); ++s)
    course.power_ups.push_back(power_up_of(plan, {standing_alone(plan.schedule, s)}, 1.0));
  for (std::size_t p = 0; p < course.power_ups.size(); ++p)
    for (std::size_t s = 0; s < course.power_ups[p].rig.segments.size(); ++s) course.places.emplace_back(p, s);
  return course;
}

/// By how much the axis may be elsewhere than the plan says [rad], which a rig with the plan's errors explains.
double tolerance_of(const Plan& plan, const std::string& axis, std::size_t segment) {
  const auto sd = [&](const char* name) { return plan.rig.has(name) ? plan.rig.number(name) : 0.0; };
  double way = 0.0;
  for (std::size_t s = 0; s <= segment; ++s) {
    const Motion* motion = motion_of(plan.schedule[s], axis);
    const bool begins = s > 0 && plan.schedule[s].run != plan.schedule[s - 1].run;
    if (begins || (motion != nullptr && motion->kind != Kind::rate)) way = 0.0;
    if (motion != nullptr && motion->kind == Kind::rate) way += std::abs(motion->value) * plan.schedule[s].duration;
  }
  const double by_rig = explained * (sd("repeatability_sd") + sd("rate_error_sd") * way);
  return std::clamp(by_rig, least_tolerance, most_tolerance);
}

/// A segment of a plan whose axis was recorded while it turned or oscillated.
struct Turned {
  std::size_t segment = 0;
  std::string axis;
  std::optional<Motion> motion = {};  ///< in place of the plan's
  double rate_departure = 0.0;        ///< [1] of the rate of the plan
};

/// The motion as recorded, where that is another than the plan's.
Turned recorded_motion(const Plan& plan, const Course& course, const Encoder& encoder, const PlacedSegment& place) {
  Turned turned{place.segment, encoder.axis};
  const Motion& motion = *motion_of(plan.schedule[place.segment], encoder.axis);
  const Angles readings = readings_in(*encoder.channel, place);
  const auto as_planned = course.planned(place.segment, encoder.axis, readings.times);
  Motion out = motion;
  const double excess = excess_rate(plan, motion, readings);
  out.value += excess;
  const auto recorded = phase_of(out, readings);
  const auto planned = as_planned ? phase_of(motion, *as_planned) : std::nullopt;
  if (!recorded || !planned) return turned;
  const double apart = std::remainder(recorded->from - planned->from, two_pi);
  const double off = std::abs(apart) + std::abs(motion.amplitude) * std::abs(recorded->wave - planned->wave);
  if (excess == 0.0 && !(off > tolerance_of(plan, encoder.axis, place.segment))) return turned;
  // on the turn that the plan has come to
  const double near =
      motion.kind == Kind::sine ? planned->from : as_planned->values.front() - motion.value * as_planned->times.front();
  out.from = near + apart;
  out.lasts = 2.0 * recorded->known_at;
  if (motion.kind == Kind::sine) out.phase = std::arg(recorded->wave);
  turned.motion = out;
  if (excess != 0.0) turned.rate_departure = excess / motion.value;
  return turned;
}

std::vector<Turned> turned_in(const Plan& plan, const Course& course, const std::vector<Encoder>& encoders,
                              const std::vector<MarkedSegment>& marks) {
  std::vector<Turned> out;
  const auto places = places_of(marks, settled_after(course.power_ups));
  for (const auto& encoder : encoders)
    for (const auto& place : places)
      if (turns_or_oscillates(motion_of(plan.schedule[place.segment], encoder.axis)))
        out.push_back(recorded_motion(plan, course, encoder, place));
  return out;
}

bool moves(const Plan& plan) {
  return !plan.rig_kind.empty() && std::ranges::any_of(plan.schedule, [](const Segment& segment) {
    return std::ranges::any_of(segment.axes, [](const auto& axis) { return turns_or_oscillates(&axis.second); });
  });
}

/// Recordings that can share a plan.
struct Sharing {
  const Plan* plan = nullptr;
  std::vector<std::size_t> recordings = {};
  std::vector<Turned> turned = {};

  bool admits(const std::vector<Turned>& more) const {
    return std::ranges::none_of(more, [&](const Turned& one) {
      return std::ranges::any_of(turned, [&](const Turned& other) {
        return one.segment == other.segment && one.axis == other.axis && (one.motion || other.motion);
      });
    });
  }
};

void share(const Plan& plan, std::size_t recording, const std::vector<Turned>& turned, std::vector<Sharing>& all) {
  auto found = std::ranges::find_if(
      all, [&](const Sharing& sharing) { return sharing.plan == &plan && sharing.admits(turned); });
  if (found == all.end()) found = all.insert(all.end(), Sharing{&plan});
  found->recordings.push_back(recording);
  found->turned.insert(found->turned.end(), turned.begin(), turned.end());
}

Plan with_turns(const Sharing& sharing) {
  Plan plan = *sharing.plan;
  for (const auto& turned : sharing.turned)
    if (turned.motion) plan.schedule[turned.segment].axes[turned.axis] = *turned.motion;
  return plan;
}

Findings said_of(const std::vector<Sharing>& all) {
  Occurrences phases{0, {}, {}}, rates{0, {}, {}};
  double widest = 0.0;
  for (const auto& sharing : all)
    for (const auto& turned : sharing.turned) {
      const std::string& label = sharing.plan->schedule[turned.segment].label;
      if (!turned.motion) continue;
      const bool other_rate = turned.rate_departure != 0.0;
      Occurrences& found = other_rate ? rates : phases;
      if (found.count++ == 0) found.first = label;
      if (std::abs(turned.rate_departure) <= std::abs(widest)) continue;
      widest = turned.rate_departure;
      rates.worst = label;
    }
  Findings findings;
  if (phases.count > 0)
    findings.push_back({Finding::Severity::info, "turn_phase_recorded", {{"segment", phases.first.label}}, "", phases});
  if (rates.count > 0)
    findings.push_back({Finding::Severity::info,
                        "turn_rate_recorded",
                        {{"segment", rates.worst.label}, {"departure", widest, "ppm"}},
                        "",
                        rates});
  return findings;
}

}  // namespace

RecordedTurns recorded_turns(const Evidence& evidence) {
  std::map<std::pair<const Plan*, bool>, Course> courses;
  std::vector<Sharing> all;
  const auto marks = marked_segments(evidence);
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    const Plan& plan = plan_of(evidence, r);
    const bool alone = recorded_alone(evidence, r);
    const auto encoders = moves(plan) ? encoders_of(evidence, r) : std::vector<Encoder>{};
    if (encoders.empty()) continue;
    if (!courses.contains({&plan, alone})) courses[{&plan, alone}] = course_of(plan, alone);
    share(plan, r, turned_in(plan, courses[{&plan, alone}], encoders, marks[r]), all);
  }
  RecordedTurns out{{}, {}, said_of(all)};
  if (out.findings.empty()) return out;
  out.plan = evidence.plan;
  out.plans = evidence.plans;
  out.plans.resize(evidence.recordings.size());
  bool first = true;
  for (const auto& sharing : all) {
    if (std::ranges::none_of(sharing.turned, [](const Turned& turned) { return turned.motion.has_value(); })) continue;
    const bool of_test = sharing.plan == &evidence.plan && std::exchange(first, false);
    if (of_test) {
      out.plan = with_turns(sharing);
      continue;
    }
    const auto own = std::make_shared<const Plan>(with_turns(sharing));
    for (const std::size_t r : sharing.recordings) out.plans[r] = own;
  }
  return out;
}

}  // namespace tumble::table
