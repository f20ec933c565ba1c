#include "tumble/tasks/optimisation/improve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/tasks/optimisation/criteria.hpp"
#include "tumble/tasks/optimisation/work.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::optimisation {
namespace {

constexpr double no_worse = 1.0 + 1e-6;   ///< [1] rounding of a predicted sd
constexpr double least_share = 0.02;      ///< of its time that a segment or visit gives away at most all but
constexpr std::size_t most_visits = 50;   ///< chosen: a schedule that people can still read and carry out
constexpr int most_periods = 64;          ///< until two motions come to whole numbers of periods together
constexpr double whole = 1e-6;            ///< [1] of a period
constexpr double shortest_segment = 1.0;  ///< [s]

std::size_t index_below(std::size_t count, double uniform) {
  return std::min(count - 1, static_cast<std::size_t>(uniform * static_cast<double>(count)));
}

/// Segments of one label: those of all power-ups change together.
struct Group {
  std::vector<std::size_t> segments;
  double period = 0.0;  ///< [s] of its motion; 0: it stands, or its motion ends
  bool fixed = false;   ///< its time is that of a move
};

std::vector<Group> groups_of(const Schedule& schedule) {
  std::vector<Group> groups;
  std::vector<std::string> labels;
  for (std::size_t s = 0; s < schedule.size(); ++s) {
    const Segment& segment = schedule[s];
    auto at = static_cast<std::size_t>(std::ranges::find(labels, segment.label) - labels.begin());
    // A label may come twice in one power-up: these are segments of their own.
    const bool twice = at < labels.size() && schedule[groups[at].segments.back()].run == segment.run;
    if (at == labels.size() || twice) {
      at = labels.size();
      labels.push_back(segment.label);
      groups.emplace_back();
    }
    groups[at].segments.push_back(s);
    groups[at].fixed = groups[at].fixed || segment.approach;
    for (const auto& [axis, motion] : segment.axes) {
      if (motion.kind == Motion::Kind::rate && motion.value != 0.0)
        groups[at].period = std::max(groups[at].period, two_pi / std::abs(motion.value));
      if (motion.kind == Motion::Kind::sine && motion.frequency > 0.0)
        groups[at].period = std::max(groups[at].period, 1.0 / motion.frequency);
      groups[at].fixed = groups[at].fixed || motion.kind == Motion::Kind::sweep;
    }
  }
  return groups;
}

bool is_whole(double ratio) { return std::abs(ratio - std::round(ratio)) < whole * std::max(1.0, ratio); }

/// Smallest times [s] that one group may give and the other take, so that both keep whole periods and samples.
std::optional<std::pair<double, double>> quantum(const Group& from, const Group& to, double interval) {
  const double ratio = static_cast<double>(from.segments.size()) / static_cast<double>(to.segments.size());
  const double step = from.period > 0.0 ? from.period : to.period > 0.0 ? to.period / ratio : interval;
  for (int k = 1; k <= most_periods; ++k) {
    const double give = k * step, take = give * ratio;
    if ((from.period <= 0.0 || is_whole(give / from.period)) && (to.period <= 0.0 || is_whole(take / to.period)) &&
        is_whole(give / interval) && is_whole(take / interval))
      return std::pair{give, take};
  }
  return std::nullopt;
}

std::optional<Schedule> time_moved(const Schedule& schedule, double rate, const RandomStream& random) {
  const auto groups = groups_of(schedule);
  const auto from = index_below(groups.size(), random.uniform(0)), to = index_below(groups.size(), random.uniform(1));
  if (from == to || groups[from].fixed || groups[to].fixed) return std::nullopt;
  const auto least = quantum(groups[from], groups[to], 1.0 / rate);
  if (!least) return std::nullopt;
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto s : groups[from].segments) shortest = std::min(shortest, schedule[s].duration);
  const double most = (shortest - shortest_segment) / least->first;
  if (most < 1.0) return std::nullopt;
  // Large and small steps alike: the share is spread evenly in its logarithm.
  const double share = std::pow(least_share, random.uniform(2));
  const double times = std::clamp(std::round(share * 0.5 * most), 1.0, std::floor(most));
  Schedule out = schedule;
  for (const auto s : groups[from].segments) out[s].duration -= times * least->first;
  for (const auto s : groups[to].segments) out[s].duration += times * least->second;
  for (auto& segment : out) segment.duration = std::round(segment.duration * rate) / rate;  // 62 s, not 61.999999999 s
  return out;
}

/// One change of visits: of what, where, for how long. At most `most` are made of them.
Visits changed(const Visits& visits, std::size_t candidates, std::size_t most, const RandomStream& random) {
  Visits out = visits;
  const std::size_t at = index_below(out.size(), random.uniform(1)), other = index_below(out.size(), random.uniform(2));
  const std::size_t candidate = index_below(candidates, random.uniform(3));
  const double mean = [&] {
    double sum = 0.0;
    for (const auto& visit : out) sum += visit.dwell;
    return sum / static_cast<double>(out.size());
  }();
  const std::size_t kind = index_below(6, random.uniform(0));
  const bool adds = kind == 1 || kind == 2;
  switch (adds && out.size() >= most ? 0 : kind) {
    case 0:
      out[at].candidate = candidate;
      break;
    case 1:
      out.insert(out.begin() + static_cast<std::ptrdiff_t>(at), {candidate, mean});
      break;
    case 2:
      out.insert(out.begin() + static_cast<std::ptrdiff_t>(at), {out[other].candidate, mean});
      break;
    case 3:
      if (out.size() > 2) out.erase(out.begin() + static_cast<std::ptrdiff_t>(at));
      break;
    case 4:
      std::swap(out[at], out[other]);
      break;
    default: {
      const double moved = std::pow(least_share, random.uniform(4)) * out[at].dwell;
      out[at].dwell -= 0.5 * moved, out[other].dwell += 0.5 * moved;
    }
  }
  return out;
}

}  // namespace

Standing standing_of(const ScheduleRow& row, const Goal& goal) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (!row.estimate) return {infinity, infinity};
  const auto criteria = criteria_of(with_prior_if_any(*row.estimate), goal.names, goal.reference);
  Standing out{1.0, goal.criterion == DesignCriterion::D ? criteria.determinant : criteria.trace};
  for (std::size_t k = 0; k < goal.most.size(); ++k)
    if (std::isfinite(goal.most[k])) out.excess = std::max(out.excess, criteria.sd[k] / goal.most[k]);
  if (out.excess < no_worse) out.excess = 1.0;
  if (std::isinf(out.value)) out.excess = infinity;
  return out;
}

bool is_allowed(const Standing& standing) { return standing.excess <= no_worse && std::isfinite(standing.value); }

ScheduleRow with_better_times(const Improving& search, ScheduleRow start, const RandomStream& random) {
  Standing best = standing_of(start, search.goal);
  for (int k = 0; k < search.steps; ++k) {
    auto schedule = time_moved(start.schedule, search.plan.sample_rate, random.split(static_cast<std::uint64_t>(k)));
    if (!schedule) continue;
    auto row = search.row(std::move(*schedule));
    if (const auto standing = standing_of(row, search.goal); standing < best) start = std::move(row), best = standing;
  }
  return start;
}

ScheduleRow with_better_visits(const Improving& search, ScheduleRow start, Visits visits, const RandomStream& random) {
  Standing best = standing_of(start, search.goal);
  const std::size_t most = std::max(most_visits, visits.size());
  for (int k = 0; k < search.steps; ++k) {
    auto trial = changed(visits, search.candidates, most, random.split(static_cast<std::uint64_t>(k)));
    auto schedule = search.fitted(trial);
    if (!schedule) continue;
    auto row = search.row(std::move(*schedule));
    const auto standing = standing_of(row, search.goal);
    if (standing < best) start = std::move(row), best = standing, visits = std::move(trial);
  }
  return start;
}

}  // namespace tumble::optimisation
