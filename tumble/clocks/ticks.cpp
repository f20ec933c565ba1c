#include "tumble/clocks/ticks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/clocks/comb.hpp"
#include "tumble/clocks/strip.hpp"

namespace tumble {
namespace {

using StampView = std::span<const double>;

constexpr double off_tick = 0.1;  ///< departure of an interval from a multiple of the tick, in ticks
constexpr double least_interval = 0.02, greatest_interval = 100.0;  ///< in ticks
constexpr double strict = 0.005, loose = 0.05;  ///< [tick] more than half a tick from a line: rounding, a late timer
constexpr std::size_t probe = 4096;             ///< samples that candidates are tried on

/// Mean of intervals over the multiples of `tick` nearest to them; 0 where one is too far from a multiple.
double refined(StampView t, double tick) {
  double sum = 0.0, multiples = 0.0;
  for (std::size_t i = 1; i < t.size(); ++i) {
    const double times = std::round((t[i] - t[i - 1]) / tick);
    sum += t[i] - t[i - 1];
    multiples += times;
  }
  if (!(multiples > 0.0)) return 0.0;
  const double mean = sum / multiples;
  for (std::size_t i = 1; i < t.size(); ++i) {
    const double times = (t[i] - t[i - 1]) / mean;
    if ((times < 0.5 && times != 0.0) || std::abs(times - std::round(times)) > off_tick * std::min(times, 2.0))
      return 0.0;
  }
  return mean;
}

/// The tick: the least interval above zero, or where the others are no multiples of it the difference of two neighbours
/// in size.
double tick_of(StampView t) {
  const StampView some = t.first(std::min(t.size(), probe));
  std::vector<double> lengths;
  for (std::size_t i = 1; i < some.size(); ++i)
    if (some[i] != some[i - 1]) lengths.push_back(some[i] - some[i - 1]);
  std::ranges::sort(lengths);
  const double least = lengths.empty() ? 0.0 : lengths.front();
  if (!(least > 0.0)) return 0.0;
  if (const double tick = refined(some, least); tick > 0.0) return tick;
  for (std::size_t i = 1; i < lengths.size(); ++i)
    if (const double step = lengths[i] - lengths[i - 1]; step > 0.1 * least) return refined(some, step);
  return 0.0;
}

/// Stamps that one line explains without a lost sample.
struct Stretch {
  std::size_t first = 0, end = 0;
  std::size_t size() const { return end - first; }
};

/// The stamps in ticks, and what may be a line through them.
struct Scale {
  StampView t;
  double tick = 0.0, half = 0.0;  ///< [s], [tick] departure from a line
  double operator()(std::size_t i) const { return (t[i] - t[0]) / tick; }
  Strip strip_at(std::size_t i) const { return {0.0, (*this)(i), half, least_interval, greatest_interval}; }
};

/// One stretch after the other, each as long as a line explains it; the longest first, up to eight.
std::vector<Stretch> stretches_of(const Scale& z) {
  constexpr std::size_t most = 8;
  std::vector<Stretch> all;
  const auto longer = [](const Stretch& a, const Stretch& b) { return a.size() > b.size(); };
  for (std::size_t first = 0, end = 0; first < z.t.size(); first = end) {
    Strip strip = z.strip_at(first);
    for (end = first + 1; end < z.t.size(); ++end)
      if (!strip.add(static_cast<double>(end - first), z(end), z.half)) break;
    all.insert(std::ranges::upper_bound(all, Stretch{first, end}, longer), {first, end});
    if (all.size() > most) all.pop_back();
  }
  return all;
}

/// Whole numbers of intervals for the stamps, and the line that explains them.
struct Counts {
  std::vector<double> x;
  Strip::Line line;                    ///< in ticks
  double lowest = 0.0, highest = 0.0;  ///< interval, in ticks
  std::size_t events = 0;              ///< times that samples are missing
};

/// The least whole number of intervals from `before`, one or more in the direction of time, with which a line of the
/// strip reaches the stamp; 0 where there is none.
double next_count(Strip& strip, double z, double half, double before, double direction) {
  if (strip.add(before + direction, z, half)) return before + direction;
  const auto [a, r] = strip.middle();
  const double about = std::max(1.0, std::round(direction * ((z - a) / r - before)));
  for (double step = std::max(2.0, about - 2.0); step <= about + 2.0; ++step)
    if (strip.add(before + direction * step, z, half)) return before + direction * step;
  return 0.0;
}

std::size_t events_in(const std::vector<double>& x) {
  std::size_t events = 0;
  for (std::size_t i = 1; i < x.size(); ++i) events += x[i] - x[i - 1] > 1.5;
  return events;
}

/// Counts from a stretch forwards and backwards. Over a long stretch the line is known so well that a stamp shows at
/// once whether a sample is missing before it: another whole number reaches no line of the strip.
std::optional<Counts> counted(const Scale& z, const Stretch& from) {
  Strip strip = z.strip_at(from.first);
  Counts out{std::vector<double>(z.t.size(), 0.0), {}, 0.0, 0.0, 0};
  std::size_t i = from.first + 1;
  for (; i < from.end; ++i) {
    out.x[i] = static_cast<double>(i - from.first);
    if (!strip.add(out.x[i], z(i), z.half)) return std::nullopt;
  }
  for (; i < z.t.size(); ++i) {
    out.x[i] = next_count(strip, z(i), z.half, out.x[i - 1], 1.0);
    if (out.x[i] == 0.0) return std::nullopt;
  }
  for (i = from.first; i-- > 0;) {
    out.x[i] = next_count(strip, z(i), z.half, out.x[i + 1], -1.0);
    if (out.x[i] == 0.0) return std::nullopt;
  }
  out.line = strip.middle(), out.lowest = strip.lowest(), out.highest = strip.highest();
  out.events = events_in(out.x);
  return out;
}

/// The least whole number of intervals after `before` that is not too early by the middle line of the strip, or else as
/// next_count(): where two samples share a tick and one is lost, the first may be the one.
double least_count(Strip& strip, double z, double half, double before) {
  constexpr double tie = 0.52;  // the middle is that near the clock, and `half` beyond it
  const auto [a, r] = strip.middle();
  const double count = std::max(before + 1.0, std::ceil((z - a - tie) / r));
  return strip.add(count, z, half) ? count : next_count(strip, z, half, before, 1.0);
}

/// The lines near a comb that go through both stamps of each doubled tick: these are at the two ends of a tick.
Strip strip_of(const Scale& z, const Comb& comb) {
  Strip strip{0.0, comb.a, comb.off_a, comb.r - comb.off_r, comb.r + comb.off_r};
  for (std::size_t i = 1; comb.r < 1.0 && i < z.t.size(); ++i) {
    if (z(i) - z(i - 1) > 0.5) continue;
    const double first = std::round((z(i) - 0.5 - comb.a) / comb.r);
    strip.add(first, z(i), z.half), strip.add(first + 1.0, z(i), z.half);
  }
  return strip;
}

/// Counts from the beginning, along lines near one that is known.
std::optional<Counts> counted(const Scale& z, const Comb& comb) {
  constexpr double spare = 0.1;  // no stamp takes the clock itself out of the strip
  Strip strip = strip_of(z, comb);
  Counts out{std::vector<double>(z.t.size(), 0.0), {}, 0.0, 0.0, 0};
  const double half = z.half + spare;
  if (!strip.add(0.0, 0.0, half)) return std::nullopt;
  for (std::size_t i = 1; i < z.t.size(); ++i) {
    out.x[i] = least_count(strip, z(i), half, out.x[i - 1]);
    if (out.x[i] == 0.0) return std::nullopt;
  }
  out.line = strip.middle(), out.lowest = strip.lowest(), out.highest = strip.highest();
  out.events = events_in(out.x);
  return out;
}

/// Counts again, now that the line is known: each sample is missing where the stamps show it first.
std::vector<double> placed(const Scale& z, const Counts& counts) {
  const auto [a, r] = counts.line;
  double high = -INFINITY;
  for (std::size_t i = 0; i < z.t.size(); ++i) high = std::max(high, z(i) - a - r * counts.x[i]);
  std::vector<double> x(z.t.size(), counts.x[0]);
  for (std::size_t i = 1; i < z.t.size(); ++i) x[i] = std::max(x[i - 1] + 1.0, std::ceil((z(i) - a - high) / r - 1e-6));
  return x;
}

/// What an interval of one tick makes of the stamps.
struct AsTicks {
  double gaps = 0.0, repeats = 0.0;
};

AsTicks as_ticks(const Scale& z) {
  AsTicks out;
  for (std::size_t i = 1; i < z.t.size(); ++i) {
    const double step = (z.t[i] - z.t[i - 1]) / z.tick;
    out.gaps += step > 1.5, out.repeats += step < 0.5;
  }
  return out;
}

/// Lines near one tick.
std::vector<Comb> combs_of(const Scale& z, const AsTicks& as) {
  std::vector<double> whole(z.t.size());
  for (std::size_t i = 0; i < whole.size(); ++i) whole[i] = std::round(z(i));
  auto combs = as.gaps > 0.0 ? comb_of_empty_ticks(whole) : std::vector<Comb>();
  if (as.repeats > 0.0)
    for (const Comb& comb : comb_of_doubled_ticks(whole)) combs.push_back(comb);
  return combs;
}

/// Of the lines of the combs and through the longest stretches the one that misses samples the fewest times.
std::optional<Counts> best_line(const Scale& z, const std::vector<Comb>& combs, double repeats) {
  std::optional<Counts> best;
  const auto take = [&](std::optional<Counts> one) {
    const double times = z.half < 0.5 + loose ? 1.0 : 0.5;  // a late timer repeats a stamp at times
    if (one &&
        may_repeat(one->line.r, one->x.back() - one->x.front(), times * repeats, static_cast<double>(one->events)) &&
        (!best || one->events < best->events))
      best = std::move(one);
  };
  for (const Comb& comb : combs) take(counted(z, comb));
  for (const Stretch& stretch : stretches_of(z)) {
    const std::size_t margin = stretch.size() / 8;  // a loss near an end may pass for a tick
    if (stretch.size() < 16) break;
    for (const Stretch& part : {stretch, Stretch{stretch.first + margin, stretch.end - margin}}) {
      if (best && best->events == 0) return best;
      take(counted(z, part));
    }
  }
  return best;
}

/// Stamps that scatter by parts of a tick about a clock near it are on no line, but repeat at times, which lost samples
/// do not make: the mean interval [tick] then is as right as the tick. 0 where they do not.
double mean_near_tick(const Scale& z, const AsTicks& as) {
  constexpr double near = 0.03, some = 3.0;
  const double intervals = static_cast<double>(z.t.size()) - 1.0, mean = z(z.t.size() - 1) / intervals;
  const double off = std::abs(mean - 1.0);
  return as.repeats >= some && as.gaps >= some && off < near && off * intervals >= some ? mean : 0.0;
}

/// The stamps as counted by a line.
TickedStamps by_line(const Scale& z, const Counts& counts) {
  const auto x = placed(z, counts);
  TickedStamps out{z.tick, counts.line.r * z.tick, {}};
  for (std::size_t i = 1; i < x.size(); ++i)
    if (const double more = x[i] - x[i - 1] - 1.0; more > 0.0)
      out.gaps.emplace_back(i - 1, static_cast<std::size_t>(more));
  return out;
}

/// Whether the line is taken rather than the tick, and whether the other may be as right.
struct Choice {
  bool line = false, unclear = false;
};

bool states_tick(double stated, std::size_t count) {
  return stated > 0.0 && std::abs(stated - 1.0) * static_cast<double>(count) < 0.5;
}

Choice choose(const Counts& counts, const AsTicks& as, double stated) {
  constexpr double beyond_doubt = 20.0;  // a record that loses a sample regularly is that rare
  constexpr double some = 3.0;           // two lost samples are at distances that a line explains one time in three
  const auto count = static_cast<double>(counts.x.size()), events = static_cast<double>(counts.events);
  const double evidence = evidence_for_line(count, as.gaps, as.repeats, events);
  if (evidence >= beyond_doubt) return {true, false};
  const bool stated_line = stated >= counts.lowest && stated <= counts.highest;
  const bool stated_tick = states_tick(stated, counts.x.size());
  if (stated_line != stated_tick) return {stated_line, false};
  return {evidence >= enough_for_line, as.gaps + as.repeats - events >= some};
}

}  // namespace

Ticks ticked(StampView t, double stated) {
  if (t.size() < 64) return {};
  const double tick = tick_of(t), greatest = std::max(std::abs(t.front()), std::abs(t.back()));
  if (!(tick > 0.0)) return {};
  const double rounding = 0.5 * std::numeric_limits<double>::epsilon() * greatest / tick;
  Scale z{t, tick, 0.5 + strict + rounding};
  const AsTicks as = as_ticks(z);
  if (as.gaps + as.repeats == 0.0) return {};
  const auto combs = combs_of(z, as);
  auto counts = best_line(z, combs, as.repeats);
  if (!counts) z.half += loose - strict, counts = best_line(z, combs, as.repeats);
  if (!counts) return {std::nullopt, mean_near_tick(z, as) * tick};
  const Choice choice = choose(*counts, as, stated / tick);
  double other = choice.unclear ? (choice.line ? 1.0 : counts->line.r) * tick : 0.0;
  const bool tick_itself = std::abs(counts->line.r - 1.0) * static_cast<double>(t.size()) < 1.0;
  if (choice.line && tick_itself && counts->events > 0 && !states_tick(stated / tick, t.size()))
    other = mean_near_tick(z, as) * tick;
  if (!choice.line) return {std::nullopt, other};
  return {by_line(z, *counts), other};
}

Ticks ticked_once(StampView t, double stated) {
  std::vector<std::size_t> last;  // of the rows with one stamp
  std::vector<double> once;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (i > 0 && t[i] == t[i - 1])
      last.back() = i;
    else
      once.push_back(t[i]), last.push_back(i);
  Ticks ticks = ticked(once, stated);
  if (ticks.stamps)
    for (auto& gap : ticks.stamps->gaps) gap.first = last[gap.first];
  return ticks;
}

}  // namespace tumble
