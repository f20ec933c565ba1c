#include "tumble/core/ticks.hpp"

#include <algorithm>
#include <cmath>

namespace tumble {
namespace {

using Stamps = std::span<const double>;

constexpr double off_tick = 0.1;      ///< departure of an interval from a multiple of the tick, in ticks
constexpr double widest = 1.1;        ///< range of the stamps about a line, in ticks
constexpr double least_ratio = 1.02;  ///< of the interval to the tick
constexpr std::size_t probe = 4096;   ///< samples that candidates are tried on

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
    if (times < 0.5 || std::abs(times - std::round(times)) > off_tick * std::min(times, 2.0)) return 0.0;
  }
  return mean;
}

/// The tick: the least interval, or where the others are no multiples of it the difference of two neighbours in size.
double tick_of(Stamps t) {
  const Stamps some = t.first(std::min(t.size(), probe));
  std::vector<double> lengths;
  for (std::size_t i = 1; i < some.size(); ++i) lengths.push_back(some[i] - some[i - 1]);
  std::ranges::sort(lengths);
  const double least = lengths.front();
  if (!(least > 0.0)) return 0.0;
  if (const double tick = refined(some, least); tick > 0.0) return tick;
  for (std::size_t i = 1; i < lengths.size(); ++i)
    if (const double step = lengths[i] - lengths[i - 1]; step > 0.1 * least) return refined(some, step);
  return 0.0;
}

/// Whole numbers of intervals for the stamps, and how well they explain them.
struct Counts {
  std::vector<double> x;
  double interval = 0.0, range = 0.0, missing = 0.0, start = 0.0;
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

/// Counts intervals along the stamps, as long as they stay within one tick of a line. Each time twice as many stamps
/// are counted, a line is fitted to them, and kept where it is the closer one: over few stamps it need not be.
///
/// Given     start  middle of the band in which the departures lie, from that of the first stamp, in ticks: -0.5 to 0.5
Counts counted(Stamps t, double interval, double tick, double start) {
  constexpr std::size_t few = 1024;
  Counts out{std::vector<double>(t.size(), 0.0), interval, 0.0, 0.0, start};
  Band band;
  for (std::size_t i = 1, next = 64; i < t.size(); ++i) {
    const double middle = i < 64 ? start * tick : 0.5 * (band.low + band.high);
    const double ahead = (t[i] - t[0] - middle) / out.interval - out.x[i - 1];
    out.x[i] = out.x[i - 1] + std::max(1.0, std::round(ahead));
    band.add(t[i] - t[0] - out.x[i] * out.interval);
    if (i + 1 != next && i + 1 != t.size()) continue;
    next *= 2;
    const double slope = slope_of(t, out.x, i + 1);
    if (const Band fitted = band_of(t, out.x, i + 1, slope); fitted.range() < band.range())
      band = fitted, out.interval = slope;
    out.range = band.range();
    if (out.range > (i < few ? 1.5 : widest) * tick) return out;
  }
  out.missing = out.x.back() - static_cast<double>(t.size() - 1);
  return out;
}

/// Mean intervals over stretches of several lengths, those that differ: where a stretch has no gap, near the interval.
std::vector<double> candidates(Stamps t, double tick) {
  constexpr std::size_t places = 24;
  constexpr double alike = 5e-4;
  std::vector<double> all;
  for (std::size_t length = t.size() - 1; length >= 16; length /= 2)
    for (std::size_t place = 0; place < places; ++place) {
      const std::size_t first = (t.size() - 1 - length) * place / (places - 1);
      const double interval = (t[first + length] - t[first]) / static_cast<double>(length);
      const auto near = [&](double other) { return std::abs(other - interval) < alike * interval; };
      if (interval > 1.01 * tick && std::ranges::none_of(all, near)) all.push_back(interval);
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

  void consider(double interval, double start) {
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
  const Stamps some = t.first(std::min(t.size(), probe));
  if (some.back() - some.front() < least_ratio * tick * static_cast<double>(some.size() - 1)) return std::nullopt;
  const auto intervals = candidates(some, tick);
  Best best(some, tick);
  // a wrong start counts a sample too many or too few at once where the interval is near the tick
  for (int part = 0; part <= 16 && !best.found(); ++part)
    for (const double interval : intervals) best.consider(interval, (part % 2 == 0 ? part : -part - 1) / 32.0);
  for (int part = -8; part <= 8 && best.found(); ++part) best.consider(best.counts().interval, part / 16.0);
  if (!best.found() || best.counts().interval < least_ratio * tick) return std::nullopt;
  const Counts all = counted(t, best.counts().interval, tick, best.counts().start);
  if (all.range > widest * tick) return std::nullopt;
  TickedStamps out{tick, all.interval, {}};
  for (std::size_t i = 1; i < t.size(); ++i)
    if (const double more = all.x[i] - all.x[i - 1] - 1.0; more > 0.0)
      out.gaps.emplace_back(i - 1, static_cast<std::size_t>(more));
  return out;
}

}  // namespace tumble
