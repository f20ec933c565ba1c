#include "tumble/reduce/vibration/windows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/clocks/clock.hpp"
#include "tumble/language/say.hpp"
#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/units/error.hpp"

namespace tumble::vibration {
namespace {

constexpr double fewest_windows = 16.0;        ///< that show a scatter
constexpr std::size_t fewest_of_channel = 16;  ///< windows

constexpr double longest_by_clock = 64.0;  ///< windows: a longer stretch has a rate of its own
constexpr double wander_of_window = 1e-3;  ///< [windows] of the stamps about their rate, from which on it wanders
constexpr double slope_variance = 0.01;    ///< [1] squared: 10 %, of a slope that is used
/// [1/window] about a multiple of it, where the window hides a tone: 5 % remain.
constexpr double hidden_by_null = 0.05;
constexpr double hidden_by_rate = 1.5;  ///< [1/span] about a multiple of half the rate, where sine and cosine are one

void refuse_backwards(const Channel& channel, const Clock& clock) {
  if (clock.backward == 0 && clock.duplicates == 0) return;
  throw Error(Error::Kind::bad_data,
              say("'{}': {} not later than the one before: such a clock does not determine counting windows; "
                  "write the stamps with more digits, or omit them and give the rate (--set rate=200)",
                  channel.name, said_count(clock.backward + clock.duplicates, "stamp")));
}

/// Samples beside a gap of the clock or beside missing samples are not usable.
void exclude_neighbours(const Channel& channel, const Clock& clock, Windows& windows) {
  const std::size_t n = channel.values.size();
  std::vector<bool> bad(n, false);
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isnan(channel.values[i])) continue;
    bad[i] = true;
    if (i > 0) bad[i - 1] = true;
    if (i + 1 < n) bad[i + 1] = true;
  }
  for (const auto& gap : clock.gaps) {
    bad[gap.after] = true;
    if (gap.after + 1 < n) bad[gap.after + 1] = true;
  }
  for (std::size_t i = 0; i < n; ++i) windows.usable[i] = !bad[i];
}

/// Stamps of samples `from` to `to` less an even clock, averaged over 257 neighbours: the mean follows a clock that
/// wanders, and not the scatter of single stamps.
std::vector<double> wander(const Channel& channel, std::size_t from, std::size_t to, double rate) {
  constexpr std::size_t half = 128;
  const std::size_t n = to - from;
  std::vector<double> total(n + 1, 0.0), mean(n);
  for (std::size_t i = 0; i < n; ++i)
    total[i + 1] = total[i] + (channel.time(from + i) - channel.time(from) - static_cast<double>(i) / rate);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t reach = std::min({half, i, n - 1 - i});  // symmetric: a drift does not shift it
    mean[i] = (total[i + reach + 1] - total[i - reach]) / static_cast<double>(2 * reach + 1);
  }
  return mean;
}

/// Even times in each part between gaps, with the wander of its clock where that is more than a thousandth of a window.
void set_even_times(const Channel& channel, const Clock& clock, Windows& windows) {
  const std::size_t n = channel.values.size();
  std::size_t from = 0;
  for (std::size_t g = 0; g <= clock.gaps.size(); ++g) {
    const std::size_t to = g < clock.gaps.size() ? clock.gaps[g].after + 1 : n;
    const double length = static_cast<double>(to - from);
    const double rate =
        length > longest_by_clock ? (length - 1.0) / (channel.time(to - 1) - channel.time(from)) : clock.rate;
    const auto departure = wander(channel, from, to, rate);
    double mean = 0.0, squares = 0.0;
    for (const double x : departure) mean += x / length;
    for (const double x : departure) squares += (x - mean) * (x - mean) / length;
    const bool wanders = std::sqrt(squares) > wander_of_window / rate;
    for (std::size_t i = from; i < to; ++i)
      windows.begin[i] =
          channel.time(from) + static_cast<double>(i - from) / rate + (wanders ? departure[i - from] : mean);
    from = to;
  }
}

void report_missing(const Channel& channel, const Clock& clock, Findings& findings) {
  std::size_t lost = 0, holes = clock.gaps.size();
  for (const auto& gap : clock.gaps) lost += gap.lost;
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    if (!std::isnan(channel.values[i])) continue;
    ++lost;
    holes += i == 0 || !std::isnan(channel.values[i - 1]) ? 1 : 0;
  }
  if (lost > 0)
    findings.push_back(
        {Finding::Severity::warning, "windows_missing", {{"windows", lost}, {"gaps", holes}}, channel.name});
}

}  // namespace

Windows even_windows(const Channel& channel, Findings& findings) {
  const std::size_t n = channel.values.size();
  if (n < fewest_of_channel)
    throw Error(Error::Kind::bad_data,
                say("'{}' has {}: too few for a vibration test", channel.name, said_count(n, "sample")));
  for (std::size_t i = 0; i < n; ++i)
    if (std::isinf(channel.values[i]))
      throw Error(Error::Kind::bad_data, say("'{}' is infinite at {:.6g} s", channel.name, channel.time(i)));
  const Clock clock = clock_of(channel);
  refuse_backwards(channel, clock);
  if (!(clock.rate > 0.0))
    throw Error(Error::Kind::bad_data, say("'{}': the stamps do not show the counting period", channel.name));
  Windows windows;
  windows.begin.resize(n);
  windows.length.assign(n, 1.0 / clock.rate);
  windows.usable.assign(n, true);
  windows.window = 1.0 / clock.rate;
  windows.scatter = clock.jitter_rms;
  if (channel.timeline.uniform())
    for (std::size_t i = 0; i < n; ++i) windows.begin[i] = channel.time(i);
  else
    set_even_times(channel, clock, windows);
  exclude_neighbours(channel, clock, windows);
  report_missing(channel, clock, findings);
  return windows;
}

Windows stamped_windows(const Channel& channel, const Windows& even) {
  Windows windows = even;
  windows.by_stamps = true;
  const std::size_t n = channel.values.size();
  for (std::size_t i = 0; i < n; ++i) {
    windows.begin[i] = channel.time(i);
    if (i + 1 < n) windows.length[i] = channel.time(i + 1) - channel.time(i);
    if (i + 1 == n) windows.usable[i] = false;
  }
  return windows;
}

double slope_with_interval(const Channel& channel, const std::vector<std::pair<double, double>>& at_rest) {
  double with = 0.0, squares = 0.0, counts = 0.0, windows = 0.0;
  for (const auto& [begin, end] : at_rest) {
    double n = 0.0, count = 0.0, time = 0.0;
    const std::size_t first = index_at(channel, begin);
    std::size_t last = first;
    for (; last + 1 < channel.values.size() && channel.time(last + 1) < end; ++last) {
      if (std::isnan(channel.values[last])) continue;
      count += channel.values[last];
      time += channel.time(last + 1) - channel.time(last);
      ++n;
    }
    if (n < fewest_windows || count == 0.0) continue;
    for (std::size_t i = first; i < last; ++i) {
      if (std::isnan(channel.values[i])) continue;
      const double interval = (channel.time(i + 1) - channel.time(i)) * n / time - 1.0;
      if (std::abs(interval) > 0.5) continue;  // a gap
      const double excess = channel.values[i] * n / count - 1.0;
      with += interval * excess;
      squares += interval * interval;
      counts += excess * excess;
      ++windows;
    }
  }
  if (!(squares > 0.0)) return std::nan("");
  const double slope = with / squares;
  const double variance = (counts - slope * with) / (windows * squares);
  return variance < slope_variance ? slope : std::nan("");
}

namespace {

constexpr int narrowest_register = 6, widest_register = 24;  ///< [bits]
constexpr double at_ends =
    1.0;  ///< [counts] from both ends of a register that is filled, beyond which the vibration reaches

/// [1] of `reach` on both sides of the expected count, within which a register is never left: it is not unwrapped.
constexpr double inner_reach = 0.9;
/// [1] of the register's size, from the expected count. After unwrapping none is farther than 0.5; one that lies so
/// near to it could be a turn off. Chosen: a margin of 3 % of the register on both sides.
constexpr double farthest_count = 0.47;
/// [1] of the squares before, which unwrapping must leave at most: counts that did not wrap are not moved for nothing.
constexpr double squares_left = 0.98;
/// [1] of `reach`, by which the mean may be off what is expected before counts that cannot be unwrapped are a finding.
constexpr double most_off = 0.1;

}  // namespace

Unwrapped unwrap(std::vector<double>& counts, double expected, double reach) {
  double low = INFINITY, high = -INFINITY, sum = 0.0, n = 0.0;
  for (const double c : counts) {
    if (std::isnan(c)) continue;
    low = std::min(low, c);
    high = std::max(high, c);
    sum += c;
    ++n;
  }
  if (n < fewest_windows || !std::isfinite(expected) || !(reach > 0.0)) return {};
  for (int bits = narrowest_register; bits <= widest_register; ++bits) {
    const double m = std::ldexp(1.0, bits);
    const bool is_signed = low < 0.0;
    const double bottom = is_signed ? -0.5 * m : 0.0, top = bottom + m - 1.0;
    const double inner = inner_reach * reach;
    if (low < bottom || high > top || (expected - inner > bottom && expected + inner < top)) continue;
    Unwrapped result{Unwrapped::Outcome::repaired, bits, 0};
    std::vector<double> moved = counts;
    double mean = 0.0, before = 0.0, after = 0.0, farthest = 0.0;
    for (double& c : moved) {
      if (std::isnan(c)) continue;
      const double turns = std::round((expected - c) / m);
      result.windows += turns != 0.0 ? 1 : 0;
      c += turns * m;
      mean += c / n;
      farthest = std::max(farthest, std::abs(c - expected));
    }
    if (result.windows == 0) continue;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (std::isnan(counts[i])) continue;
      before += (counts[i] - sum / n) * (counts[i] - sum / n);
      after += (moved[i] - mean) * (moved[i] - mean);
    }
    if (farthest < farthest_count * m && after < squares_left * before) {
      counts = std::move(moved);
      return result;
    }
    const bool filled = low <= bottom + at_ends && high >= top - at_ends;
    if (filled || std::abs(sum / n - expected) > most_off * reach)
      return {Unwrapped::Outcome::ambiguous, bits, result.windows};
  }
  return {};
}

std::optional<Finding> hidden_tone(double frequency, double window, double interval, double span,
                                   const std::string& where) {
  constexpr auto error = Finding::Severity::error;
  const double turns = frequency * window, null = std::round(turns);
  if (null > 0.0 && std::abs(turns - null) < hidden_by_null)
    return Finding{error,
                   "tone_on_null",
                   {{"frequency", frequency, "Hz"},
                    {"window", window, "s"},
                    {"lower", (null - 0.1) / window, "Hz"},
                    {"upper", (null + 0.1) / window, "Hz"}},
                   where};
  const double half = 0.5 / interval, multiple = half * std::round(frequency / half);
  if (!(multiple > 0.0) || std::abs(frequency - multiple) * span >= hidden_by_rate) return {};
  const double apart = next_frequency(multiple, span);
  return Finding{error,
                 "tone_on_half_rate",
                 {{"frequency", frequency, "Hz"},
                  {"rate", 1.0 / interval, "Hz"},
                  {"lower", multiple - apart, "Hz"},
                  {"upper", multiple + apart, "Hz"}},
                 where};
}

}  // namespace tumble::vibration
