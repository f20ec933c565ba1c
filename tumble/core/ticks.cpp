#include "tumble/core/ticks.hpp"

#include <algorithm>
#include <cmath>

namespace tumble {
namespace {

using Stamps = std::span<const double>;

constexpr double off_tick = 0.1;     ///< departure of an interval from a multiple of the tick, in ticks
constexpr double widest = 1.1;       ///< range of the stamps about a line, in ticks
constexpr double fewest = 8.0;       ///< stamps that an interval unlike the tick moves by a tick; fewer are chance
constexpr std::size_t probe = 4096;  ///< samples that candidates are tried on

/// Mean of intervals over the multiples of `tick` nearest to them; 0 where one is too far from a multiple.
double refined(Stamps t, double tick) {
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
double tick_of(Stamps t) {
  const Stamps some = t.first(std::min(t.size(), probe));
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

/// Whole numbers of intervals for the stamps, and how well they explain them.
struct Counts {
  std::vector<double> x;
  double interval = 0.0, range = 0.0, low = 0.0, missing = 0.0;
  std::optional<double> start;  ///< middle of the band from the departure of the first stamp, in ticks: -0.5 to 0.5
};

/// Slope of the straight line of t over x, by least squares.
double slope_of(Stamps t, const std::vector<double>& x, std::size_t count) {
  double mean_x = 0.0, mean_t = 0.0, xx = 0.0, xt = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    mean_x += x[i] / static_cast<double>(count);
    mean_t += (t[i] - t[0]) / static_cast<double>(count);
  }
  for (std::size_t i = 0; i < count; ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xt += (x[i] - mean_x) * (t[i] - t[0] - mean_t);
  }
  return xt / xx;
}

/// Least and greatest departure of the first stamps from even spacing.
struct Band {
  double low = 0.0, high = 0.0;

  void add(double departure) { low = std::min(low, departure), high = std::max(high, departure); }
  double range() const { return high - low; }
};

Band band_of(Stamps t, const std::vector<double>& x, std::size_t count, double interval) {
  Band band;
  for (std::size_t i = 0; i < count; ++i) band.add(t[i] - t[0] - x[i] * interval);
  return band;
}

/// The next whole number: one more, or as many more as keep the departure of stamp `t` [s] within `high` [s].
double next_count(double t, double before, double interval, double high) {
  return std::max(before + 1.0, std::ceil((t - high) / interval));
}

/// Counts intervals along the stamps. With a start, the whole number nearest to the middle of the band is taken, which
/// shows a lost sample at once; without, a sample is missing only where the stamps would otherwise leave the widest
/// band above the least of them, which is right whatever the start. Each time twice as many stamps are counted, a line
/// is fitted to them, and kept where it is the closer one: over few stamps it need not be, and before any stamp shows
/// how the interval differs from the tick it would be the tick.
Counts counted(Stamps t, double interval, double tick, std::optional<double> start) {
  constexpr std::size_t few = 1024;
  Counts out{std::vector<double>(t.size(), 0.0), interval, 0.0, 0.0, 0.0, start};
  Band band;
  for (std::size_t i = 1, next = 64; i < t.size(); ++i) {
    const double middle = i < 64 ? start.value_or(0.0) * tick : 0.5 * (band.low + band.high);
    const double high = start ? middle + 0.5 * out.interval : band.low + widest * tick;
    out.x[i] = next_count(t[i] - t[0], out.x[i - 1], out.interval, high);
    band.add(t[i] - t[0] - out.x[i] * out.interval);
    if (i + 1 != next && i + 1 != t.size()) continue;
    next *= 2;
    const bool shown = start || std::abs(out.interval / tick - 1.0) * static_cast<double>(i) >= fewest;
    const double slope = shown ? slope_of(t, out.x, i + 1) : out.interval;
    if (const Band fitted = band_of(t, out.x, i + 1, slope); fitted.range() < band.range())
      band = fitted, out.interval = slope;
    out.range = band.range(), out.low = band.low;
    if (out.range > (i < few ? 1.5 : widest) * tick) return out;
  }
  out.missing = out.x.back() - static_cast<double>(t.size() - 1);
  return out;
}

/// Counts again, now that interval and band are known: each sample is missing where the stamps show it first.
std::vector<double> placed(Stamps t, const Counts& counts) {
  std::vector<double> x(t.size(), 0.0);
  const double high = counts.low + counts.range + 1e-6 * counts.interval;
  for (std::size_t i = 1; i < t.size(); ++i) x[i] = next_count(t[i] - t[0], x[i - 1], counts.interval, high);
  return x;
}

/// Mean intervals over stretches of several lengths, those that differ: where a stretch has no gap, near the interval.
std::vector<double> candidates(Stamps t) {
  constexpr std::size_t places = 24;
  constexpr double alike = 5e-4;
  std::vector<double> all;
  for (std::size_t length = t.size() - 1; length >= 16; length /= 2)
    for (std::size_t place = 0; place < places; ++place) {
      const std::size_t first = (t.size() - 1 - length) * place / (places - 1);
      const double interval = (t[first + length] - t[first]) / static_cast<double>(length);
      const auto near = [&](double other) { return std::abs(other - interval) < alike * interval; };
      if (std::ranges::none_of(all, near)) all.push_back(interval);
    }
  return all;
}

/// Of those that explain the stamps the one that misses the fewest samples.
class Best {
 public:
  Best(Stamps t, double tick) : t_(t), tick_(tick) {}

  bool found() const { return !counts_.x.empty(); }
  bool perfect() const { return found() && counts_.missing == 0.0; }
  const Counts& counts() const { return counts_; }

  void consider(double interval, std::optional<double> start = {}) {
    if (perfect()) return;
    Counts one = counted(t_, interval, tick_, start);
    if (one.range <= widest * tick_ && (!found() || one.missing < counts_.missing)) counts_ = std::move(one);
  }

 private:
  Stamps t_;
  double tick_;
  Counts counts_;
};

}  // namespace

std::optional<TickedStamps> ticked(Stamps t) {
  if (t.size() < 64) return std::nullopt;
  const double tick = tick_of(t);
  if (!(tick > 0.0)) return std::nullopt;
  const auto count = static_cast<double>(t.size());
  const auto is_tick = [&](double interval) { return std::abs(interval / tick - 1.0) * count < fewest; };
  if (is_tick((t.back() - t.front()) / (count - 1.0))) return std::nullopt;
  Best best(t.first(std::min(t.size(), probe)), tick);
  const auto intervals = candidates(t.first(std::min(t.size(), probe)));
  for (const double interval : intervals) best.consider(interval);
  for (int part = 0; part <= 16; ++part)
    for (const double interval : intervals)
      if (interval > tick) best.consider(interval, (part % 2 == 0 ? part : -part - 1) / 32.0);
  if (!best.found() || is_tick(best.counts().interval)) return std::nullopt;
  const Counts all = counted(t, best.counts().interval, tick, best.counts().start);
  if (all.range > widest * tick) return std::nullopt;
  const auto x = placed(t, all);
  if (band_of(t, x, t.size(), all.interval).range() > widest * tick) return std::nullopt;
  // stamps two ticks apart are even by chance where as many samples are missing anyhow
  if (all.interval > tick && 3.0 * (all.interval / tick - 1.0) * count < x.back() - (count - 1.0)) return std::nullopt;
  TickedStamps out{tick, all.interval, {}};
  for (std::size_t i = 1; i < t.size(); ++i)
    if (const double more = x[i] - x[i - 1] - 1.0; more > 0.0)
      out.gaps.emplace_back(i - 1, static_cast<std::size_t>(more));
  return out;
}

}  // namespace tumble
