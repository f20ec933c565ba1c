// Whether axes turn as they were told. What settles, and what an attempt needs, is decided elsewhere: here it is about
// motions that nobody has commanded, which stop the run.

#include <cmath>

#include "tumble/station/executive/turn.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::executive {
namespace {

using Verdict = RateWatch::Verdict;

constexpr double beyond_limit = 0.05;    // [1] of the limit: a controller that is told its limit overshoots
constexpr double overshoot = 0.25;       // [1] of the change of rate
constexpr double tolerances = 10.0;      // that count as a motion of its own
constexpr double slow = degree;          // [rad/s] what is slower is left to the settle rule
constexpr double slow_of_limit = 0.02;   // [1]
constexpr int fast_readings = 2;         // one may be a wrong digit on the line
constexpr double strange_for = 1.0;      // [s]
constexpr double derived_for = 2.0;      // [s]: a reply that comes late spoils the slope for one second
constexpr std::size_t derived_from = 5;  // positions
constexpr double astray_for = 10.0;      // [s] without coming nearer to what was demanded

/// [rad/s] a rate that may do harm, where another was commanded.
double harmful(const StationAxis& axis, double commanded) {
  return tolerances * rate_tolerance(axis, commanded) + std::max(slow, slow_of_limit * axis.max_rate.value_or(0.0));
}

/// The rates that the command explains, without their margin; absent: all.
std::optional<std::pair<double, double>> explained(const AxisProgress& progress) {
  const auto& watch = progress.watch;
  const auto way = [&](double to) { return std::pair(std::min(watch.low, to), std::max(watch.high, to)); };
  switch (progress.demand) {
    case Demand::rate:
      return progress.arrived ? std::pair(progress.value, progress.value) : way(progress.value);
    case Demand::rest:
      return progress.at_rest >= readings_at_rest ? std::pair(0.0, 0.0) : way(0.0);
    case Demand::position:
      if (progress.arrived) return std::pair(0.0, 0.0);
      [[fallthrough]];
    case Demand::moving:
    case Demand::sine:
      if (!watch.fastest) return std::nullopt;
      return std::pair(std::min(watch.low, -*watch.fastest), std::max(watch.high, *watch.fastest));
    default:
      return std::nullopt;
  }
}

bool is_strange(const StationAxis& axis, const AxisProgress& progress) {
  const auto range = explained(progress);
  if (!range) return false;
  const double most = std::max(std::abs(range->first), std::abs(range->second));
  const double margin = harmful(axis, most) + overshoot * std::max(range->second - range->first, 0.0);
  return *progress.rate < range->first - margin || *progress.rate > range->second + margin;
}

/// Since when something holds, or nothing.
bool holds_for(std::optional<double>& since, bool holds, double now, double seconds) {
  if (!holds) since.reset();
  if (holds && !since) since = now;
  return holds && now - *since >= seconds;
}

/// A rate that was demanded and is not approached, while the axis turns.
bool is_astray(const StationAxis& axis, AxisProgress& progress, double now) {
  auto& watch = progress.watch;
  if (progress.demand != Demand::rate && progress.demand != Demand::rest) return false;
  const double wanted = progress.demand == Demand::rate ? progress.value : 0.0;
  const double departure = std::abs(*progress.rate - wanted), least = harmful(axis, wanted);
  const double nearer = std::max(rate_tolerance(axis, wanted), 0.01 * least);
  const bool harmless = departure <= least || std::abs(*progress.rate) <= least;
  if (harmless || watch.nearest < 0.0 || departure < watch.nearest - nearer) {
    watch.nearest = harmless ? -1.0 : departure;
    watch.nearest_at = now;
  }
  return !harmless && now - watch.nearest_at > astray_for;
}

/// Whether the device has not answered what moves the axis.
bool is_told(const Turn& turn, std::size_t device) {
  const auto moves = [](const PendingRequest& one) {
    return one.purpose == Purpose::motion || one.purpose == Purpose::rest || one.purpose == Purpose::finish ||
           one.purpose == Purpose::verify;
  };
  const auto& progress = turn.state.devices[device];
  return (progress.asked && moves(*progress.asked)) || std::ranges::any_of(progress.waiting, moves);
}

Sentence words_of(const StationAxis& axis, const AxisProgress& progress) {
  const Unit unit = Unit::parse("deg/s");
  const auto text = [&](double rate) { return Name{format_in(rate, unit) + " deg/s"}; };
  const double rate = unit.from_si(*progress.rate);
  if (progress.watch.verdict == Verdict::too_fast)
    return say("{} turns at {:.4g} deg/s: the station allows {}", Name{axis.name}, rate, text(*axis.max_rate));
  if (progress.demand == Demand::rate)
    return say("{} turns at {:.4g} deg/s, and {} is commanded", Name{axis.name}, rate, text(progress.value));
  if (progress.watch.fastest && !progress.arrived && progress.demand != Demand::rest)
    return say("{} turns at {:.4g} deg/s, and {} at most is commanded", Name{axis.name}, rate,
               text(*progress.watch.fastest));
  return say("{} turns at {:.4g} deg/s, and rest is commanded", Name{axis.name}, rate);
}

}  // namespace

double rate_tolerance(const StationAxis& axis, double rate) {
  return axis.settle.rate.value_or(standard_zero) + axis.settle.relative_rate * std::abs(rate);
}

void watch_rate(Turn& turn, const StationAxis& axis, AxisProgress& progress, bool derived) {
  if (axis.kind != StationAxis::Kind::angle || !progress.rate) return;
  if (derived && progress.turned_at.size() < derived_from) return;
  auto& watch = progress.watch;
  const double now = turn.now(), rate = *progress.rate;
  const bool fast =
      axis.max_rate && std::abs(rate) > (1.0 + beyond_limit) * *axis.max_rate + rate_tolerance(axis, rate);
  watch.readings = fast ? watch.readings + 1 : 0;
  const bool too_fast = holds_for(watch.too_fast, fast, now, derived ? derived_for : 0.0);
  if (too_fast && watch.readings >= fast_readings) watch.verdict = Verdict::too_fast;
  if (is_told(turn, axis.device) && !watch.strange) {
    watch.low = std::min(watch.low, rate);
    watch.high = std::max(watch.high, rate);
    return;
  }
  const bool strange = is_strange(axis, progress);
  if (holds_for(watch.strange, strange, now, derived ? derived_for : strange_for) && watch.verdict == Verdict::good)
    watch.verdict = Verdict::strange;
  if (is_astray(axis, progress, now) && watch.verdict == Verdict::good) watch.verdict = Verdict::astray;
}

void check_rates(Turn& turn) {
  for (std::size_t i = 0; i < turn.state.axes.size() && is_active(turn.state.phase); ++i)
    if (turn.state.axes[i].watch.verdict != Verdict::good)
      begin_safe(turn, RunPhase::stopping, RunEnding::stopped, words_of(turn.station().axes[i], turn.state.axes[i]));
}

}  // namespace tumble::executive
