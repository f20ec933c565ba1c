#include "tumble/reduce/table/recorded_angles.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/core/columns.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/reduce/order_of_marks.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/reduce/table/encoders.hpp"
#include "tumble/reduce/table/kept_motion.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::table {
namespace {

using Kind = Motion::Kind;
using Severity = Finding::Severity;
constexpr double drift_of_tolerance = 0.02;  ///< [1] of the tolerance, below which a drift is no finding

constexpr double significant = 6.0;            ///< standard deviations
constexpr double arrived = 20.0 * arcsecond;   ///< [rad] by which an axis that has arrived creeps
constexpr double still_moving = 0.1 * degree;  ///< [rad] between two readings

constexpr double fewest_of_gain = 5.0;  ///< stands of an axis: three beyond its line
constexpr double rare_gain = 1e-6;      ///< probability of such a gain by the scatter of the stands
/// [1] More is no gain of an encoder, but one that stands still or counts in the other direction: the angles say it.
constexpr double greatest_gain = 0.01;
constexpr double least_off = 1.0 * arcsecond;  ///< [rad] over all angles of an axis: less is no fault of an encoder

struct Mean {
  double value = 0.0, sd = 0.0;
  std::size_t count = 0;
};

/// Mean of the readings [from, to), each nearest to `command` where turns are not counted. The resolution of the
/// readings remains in it.
Mean mean_of(const Channel& channel, std::size_t from, std::size_t to, double command, bool counts_turns, double step) {
  Mean mean;
  double squares = 0.0;
  for (std::size_t i = from; i < std::min(to, channel.values.size()); ++i) {
    if (std::isnan(channel.values[i])) continue;
    double off = channel.values[i] - command;
    if (!counts_turns) off = std::remainder(off, two_pi);
    mean.value += off;
    squares += off * off;
    ++mean.count;
  }
  if (mean.count == 0) return mean;
  const auto n = static_cast<double>(mean.count);
  mean.value /= n;
  const double scatter = n > 1.0 ? std::max(0.0, squares - n * mean.value * mean.value) / (n - 1.0) : 0.0;
  mean.sd = std::sqrt(scatter / n + step * step / 12.0);
  mean.value += command;
  return mean;
}

/// The first of the readings before `end` that are as the last one: a move may take longer than the plan says.
std::size_t end_of_move(const Encoder& encoder, std::size_t begin, std::size_t end) {
  const auto& values = encoder.channel->values;
  if (end == 0 || std::isnan(values[end - 1])) return end == 0 ? 0 : end - 1;
  std::size_t first = end - 1;
  while (first > begin && !(std::abs(values[first - 1] - values[end - 1]) > arrived + 3.0 * encoder.step)) --first;
  return first;
}

/// Where the axis stood in each segment; a rest without a reading is skipped.
std::vector<Stand> stands_of(const Plan& plan, std::size_t recording, const Encoder& encoder,
                             const std::vector<PlacedSegment>& places, double settling) {
  std::vector<Stand> stands;
  const auto commands = commands_of(plan.schedule, encoder.axis);
  const Channel& channel = *encoder.channel;
  for (const auto& place : places) {
    const double command = commands[place.segment];
    if (std::isnan(command)) continue;
    const Segment& segment = plan.schedule[place.segment];
    const Motion* motion = motion_of(segment, encoder.axis);
    const bool slews = motion != nullptr && motion->kind == Kind::slew;
    const double step = 1.0 / mean_rate(channel), slack = stamp_slack(place.end, step);
    if (place.begin > channel.time(channel.values.size() - 1) + slack) continue;  // the recording ends before
    // an axis that stands while another one moves is read all the time
    const bool beside = motion == nullptr && place.settled + settling + slack >= place.end;
    const double begin = beside ? place.begin : place.settled;
    const Kept kept = slews ? Kept{begin, place.end} : kept_motion(encoder, motion, begin, place.end);
    // the last reading of which the interval ends with the segment: the next one holds a part of the next motion
    const std::size_t end = index_at(channel, kept.until - step + slack);
    std::size_t from = index_at(channel, kept.from + (slews || beside ? 0.0 : settling) - slack);
    if (slews) from = std::max(from, end_of_move(encoder, index_at(channel, place.begin), end));
    const auto mean = [&](std::size_t a, std::size_t b) {
      return mean_of(channel, a, b, command, encoder.counts_turns, encoder.step);
    };
    const Mean all = mean(from, end), first = mean(from, from + (end - from) / 2),
               second = mean(from + (end - from) / 2, end);
    if (all.count == 0) continue;
    Stand stand{recording, segment.label, segment.run, encoder.axis, command, all.value, all.sd};
    if (first.count > 1 && second.count > 1) {
      stand.drift = second.value - first.value;
      stand.drift_sd = std::hypot(first.sd, second.sd);
    }
    if (slews && end > 1 && place.settled + 2.0 * step < place.end)
      stand.moving = std::abs(channel.values[end - 1] - channel.values[end - 2]) > still_moving;
    stands.push_back(stand);
  }
  return stands;
}

/// Puts the angles into the schedule. An axis that a segment does not mention remains where it was, unless it was
/// recorded elsewhere: positions that were taken in another order leave it there.
///
/// Given     tolerance  [rad], as with_recorded_angles
void replace_angles(const std::vector<Stand>& stands, double tolerance, Plan& plan) {
  struct Sum {
    double recorded = 0.0, commanded = 0.0, count = 0.0;
  };
  std::map<std::tuple<std::string, int, std::string>, Sum> sums;
  for (const auto& stand : stands) {
    Sum& sum = sums[{stand.label, stand.run, stand.axis}];
    sum.recorded += stand.recorded;
    sum.commanded += stand.commanded;
    sum.count += 1.0;
  }
  for (const auto& [key, sum] : sums)
    for (auto& segment : plan.schedule) {
      const auto& [label, run, axis] = key;
      if (segment.label != label || segment.run != run) continue;
      const double angle = sum.recorded / sum.count;
      const auto motion = segment.axes.find(axis);
      if (motion == segment.axes.end()) {
        if (std::abs(sum.recorded - sum.commanded) > tolerance * sum.count)
          segment.axes[axis] = {.kind = Kind::hold, .value = angle};
      } else if (motion->second.kind == Kind::hold) {
        motion->second.value = angle;
      } else if (motion->second.kind == Kind::slew) {
        motion->second.to = angle;
      }
    }
}

/// Positioning errors that remain where every axis that moves was read.
void replace_repeatability(const std::vector<Stand>& stands, const std::vector<std::string>& axes, Plan& plan) {
  for (const auto& axis : find_rig(plan.rig_kind).axes())
    for (const auto& segment : plan.schedule)
      if (!is_mount_axis(axis.name) && motion_of(segment, axis.name) != nullptr &&
          std::ranges::find(axes, axis.name) == axes.end())
        return;
  const auto options = find_rig(plan.rig_kind).options();
  if (stands.empty() || std::ranges::none_of(options, [](const Option& o) { return o.name == "repeatability_sd"; }))
    return;
  double squares = 0.0;
  for (const auto& stand : stands) squares += stand.sd * stand.sd / static_cast<double>(stands.size());
  plan.rig.set_number("repeatability_sd", std::sqrt(squares), Unit::parse("arcsec"));
}

void judge(const std::vector<Stand>& stands, double tolerance, Findings& findings) {
  for (const auto& stand : stands)
    if (stand.moving) findings.push_back({Severity::error, "move_not_over", {{"axis", stand.axis}}, stand.label});
  for (const auto& stand : stands)
    if (!stand.moving && std::abs(stand.drift) > std::max(significant * stand.drift_sd, drift_of_tolerance * tolerance))
      findings.push_back(
          {Severity::error, "axis_not_at_rest", {{"axis", stand.axis}, {"drift", stand.drift, "arcsec"}}, stand.label});
  Occurrences off{0, {}, {}};
  const Stand* worst = nullptr;
  for (const auto& stand : stands) {
    const double apart = std::abs(stand.recorded - stand.commanded);
    if (!(apart > tolerance)) continue;
    if (off.count++ == 0) off.first = stand.label;
    if (worst == nullptr || apart > std::abs(worst->recorded - worst->commanded)) worst = &stand;
  }
  if (worst == nullptr) return;
  off.worst = worst->label;
  findings.push_back({Severity::warning,
                      "angle_off_plan",
                      {{"segment", worst->label},
                       {"axis", worst->axis},
                       {"recorded", worst->recorded, "deg"},
                       {"commanded", worst->commanded, "deg"}},
                      "",
                      off});
}

/// The line of recorded less commanded angles over the commanded ones of an axis.
struct AngleGain {
  std::string axis;
  double gain = 0.0;  ///< [1]
  double span = 0.0;  ///< [rad] of the commanded angles
};

/// The gain of an encoder by the stands of its axis, where it stands out of what they scatter about the line, by no less
/// than `least_sd` [rad].
std::optional<AngleGain> gain_of(const std::vector<Stand>& stands, const std::string& axis, double least_sd) {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0, lowest = INFINITY, highest = -INFINITY;
  const auto each = [&](const auto& with) {
    for (const Stand& stand : stands)
      if (stand.axis == axis && !stand.moving) with(stand.commanded, stand.recorded - stand.commanded);
  };
  each([&](double command, double off) {
    n += 1.0, x += command, y += off;
    lowest = std::min(lowest, command), highest = std::max(highest, command);
  });
  if (n < fewest_of_gain) return {};
  each([&](double command, double off) {
    xx += (command - x / n) * (command - x / n);
    xy += (command - x / n) * (off - y / n);
    yy += (off - y / n) * (off - y / n);
  });
  if (!(xx > 0.0)) return {};
  const double gain = xy / xx, scatter = std::sqrt(std::max(0.0, yy - gain * xy) / (n - 2.0));
  const double sd = std::max(scatter, least_sd) / std::sqrt(xx);
  const double size = std::abs(gain), span = highest - lowest;
  const double by_chance = std::max(student_quantile(1.0 - 0.5 * rare_gain, n - 2.0) * sd, least_off / span);
  if (!(size > by_chance) || size > greatest_gain) return {};
  return AngleGain{axis, gain, span};
}

/// Encoders whose angles differ from the plan in proportion: over whole turns a disc cannot be off, but the number of its
/// lines can be stated wrongly.
void judge_gains(const std::vector<Stand>& stands, const std::vector<std::string>& axes, const Plan& plan,
                 Findings& findings) {
  const bool states = plan.rig.texts().contains("repeatability_sd") && !plan.rig.flag("ideal");
  const double least_sd = states ? plan.rig.number("repeatability_sd") : 0.0;
  for (const std::string& axis : axes)
    if (const auto found = gain_of(stands, axis, least_sd))
      findings.push_back({Severity::warning,
                          "angles_off_in_proportion",
                          {{"axis", found->axis},
                           {"gain", found->gain, "ppm"},
                           {"off", found->gain * found->span, "arcsec"},
                           {"span", found->span, "deg"}}});
}

/// How much later [s] than the plan says an axis passes the middle between two angles [rad]; NaN: it does not pass it.
double delay_of(const Channel& channel, const PlacedSegment& place, double from, double to) {
  const double sense = to > from ? 1.0 : -1.0, middle = 0.5 * (from + to);
  for (std::size_t i = index_at(channel, place.begin); i < channel.values.size() && channel.time(i) < place.end; ++i)
    if (sense * (channel.values[i] - middle) >= 0.0)
      return channel.time(i) + 0.5 / mean_rate(channel) - 0.5 * (place.begin + place.settled);
  return std::nan("");
}

/// Slews that pass their middle at another time than the plan says, by more than two samples and a second.
void judge_times(const Plan& plan, const Encoder& encoder, const std::vector<PlacedSegment>& places,
                 Findings& findings) {
  if (!encoder.counts_turns) return;
  const auto commands = commands_of(plan.schedule, encoder.axis);
  for (const auto& place : places) {
    const Segment& segment = plan.schedule[place.segment];
    const Motion* motion = motion_of(segment, encoder.axis);
    if (motion == nullptr || motion->kind != Kind::slew || place.segment == 0) continue;
    const double from = commands[place.segment - 1];
    if (!(std::abs(motion->to - from) > 0.5)) continue;
    const double delay = delay_of(*encoder.channel, place, from, motion->to);
    if (!(std::abs(delay) > 2.0 / mean_rate(*encoder.channel) + 1.0)) continue;
    findings.push_back({Severity::warning,
                        delay > 0.0 ? "turn_late" : "turn_early",
                        {{"axis", encoder.axis}, {"offset", std::abs(delay), "s"}},
                        segment.label});
  }
}

}  // namespace

std::vector<double> commands_of(const Schedule& schedule, const std::string& axis) {
  std::vector<double> commands;
  double now = 0.0;
  for (std::size_t s = 0; s < schedule.size(); ++s) {
    if (s > 0 && schedule[s].run != schedule[s - 1].run) now = 0.0;
    if (const Motion* motion = motion_of(schedule[s], axis)) {
      const bool stands = motion->kind == Kind::hold || motion->kind == Kind::slew;
      now = motion->kind == Kind::hold ? motion->value : stands ? motion->to : std::nan("");
    }
    commands.push_back(now);
  }
  return commands;
}

RecordedAngles with_recorded_angles(const Evidence& evidence, double settling, double tolerance) {
  RecordedAngles out{evidence, {}, {}, {}};
  std::map<const Plan*, std::vector<Stand>> by_plan;
  ConductedTests tests;
  const auto marks = marked_segments(evidence);
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    const Plan& plan = plan_of(evidence, r);
    if (plan.rig_kind.empty() || plan.schedule.empty()) continue;
    const bool alone = recorded_alone(evidence, r);
    const auto settled = settled_after(tests.of(plan, marks[r], alone));
    const auto places = places_of(marks[r], alone ? std::vector(plan.schedule.size(), 0.0) : settled);
    for (const auto& encoder : encoders_of(evidence, r)) {
      if (std::ranges::find(out.axes, encoder.axis) == out.axes.end()) out.axes.push_back(encoder.axis);
      judge_times(plan, encoder, places, out.findings);
      for (auto& stand : stands_of(plan, r, encoder, places, settling)) {
        by_plan[&plan].push_back(stand);
        out.stands.push_back(std::move(stand));
      }
    }
  }
  for (const auto& [plan, stands] : by_plan) {
    const auto changed = [&](Plan copy) {
      replace_angles(stands, tolerance, copy);
      replace_repeatability(stands, out.axes, copy);
      return copy;
    };
    if (plan == &evidence.plan) out.evidence.plan = changed(*plan);
    for (auto& own : out.evidence.plans)
      if (own.get() == plan) own = std::make_shared<const Plan>(changed(*plan));
  }
  judge(out.stands, tolerance, out.findings);
  judge_gains(out.stands, out.axes, evidence.plan, out.findings);
  return out;
}

Table angles_table(const RecordedAngles& angles) {
  return tabulate("angles", "where the axes stood: commanded by the plan and recorded by the encoders", angles.stands,
                  {{"label", &Stand::label},
                   {"run", &Stand::run},
                   {"axis", &Stand::axis},
                   {"commanded", "deg", &Stand::commanded},
                   {"recorded", "deg", &Stand::recorded},
                   {"difference", "arcsec", [](const Stand& s) { return s.recorded - s.commanded; }},
                   {"sd", "arcsec", &Stand::sd}});
}

}  // namespace tumble::table
