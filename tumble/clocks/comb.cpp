#include "tumble/clocks/comb.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

#include "tumble/clocks/strip.hpp"

namespace tumble {
namespace {

using Sum = std::complex<double>;
using WholeTicks = std::span<const double>;

constexpr double widest = 0.02;  ///< of a tick that the interval may differ from it
constexpr std::size_t fewest_teeth = 5;

/// The line whose ticks, empty (+1) or doubled (-1), are at c + k / f.
Comb comb_at(double turn, double f, double sign) {
  Comb comb;
  comb.r = 1.0 / (1.0 - sign * f);
  comb.a = sign * comb.r * turn - 0.5;
  comb.a -= comb.r * std::round(comb.a / comb.r);
  return comb;
}

/// Which ticks have no stamp.
struct EmptyTicks {
  std::vector<bool> taken;
  std::vector<double> at;  ///< those between neighbours that are near each other
  bool holds(double tick) const { return tick >= 0.0 && !taken[static_cast<std::size_t>(tick)]; }
  bool near(double tick) const {
    return tick + 1.5 > static_cast<double>(taken.size()) || holds(tick) || holds(tick - 1.0) || holds(tick + 1.0);
  }
};

EmptyTicks empty_ticks(WholeTicks whole) {
  constexpr double near = 8.5;
  EmptyTicks empty{std::vector<bool>(static_cast<std::size_t>(whole.back()) + 2, false), {}};
  for (std::size_t i = 0; i < whole.size(); ++i) {
    empty.taken[static_cast<std::size_t>(whole[i])] = true;
    if (i > 0 && whole[i] - whole[i - 1] < near)
      for (double tick = whole[i - 1] + 1.0; tick < whole[i]; ++tick) empty.at.push_back(tick);
  }
  return empty;
}

/// The lines through the teeth of a comb, in numbers of the tooth.
struct Chain {
  Strip teeth;
  std::size_t count = 0;
};

/// The comb that begins with two empty ticks, if each of its teeth up to the end is an empty tick.
std::optional<Chain> chain_from(const EmptyTicks& empty, double first, double second) {
  constexpr double half = 0.52;
  const double last = static_cast<double>(empty.taken.size()) - 2.0, about = second - first;
  Chain chain{Strip{0.0, first, half, about - 1.1, about + 1.1}, 2};
  if (!chain.teeth.add(1.0, second, half)) return std::nullopt;
  for (double k = 2.0;; ++k, ++chain.count) {
    const auto [c, period] = chain.teeth.middle();
    const double middle = std::round(c + k * period);
    if (middle + 1.0 >= last) return chain;
    bool found = false;
    for (const double step : {0.0, 1.0, -1.0})
      if (!found && empty.holds(middle + step)) found = chain.teeth.add(k, middle + step, half);
    if (!found) return std::nullopt;
  }
}

Sum sum_at(WholeTicks ticks, double f) {
  Sum sum;
  for (const double at : ticks) sum += std::polar(1.0, -2.0 * std::numbers::pi * f * at);
  return sum;
}

/// The frequency with the greatest sum, on a grid.
struct Peak {
  double f = 0.0, size = 0.0;
};

/// Four points for each width of a line, each by turning the terms of the one before.
Peak highest(WholeTicks ticks, double length) {
  const double step = 0.25 / length, lowest = 1.5 / length;  // fewer than two periods are no line
  std::vector<Sum> terms, turns;
  for (const double at : ticks) {
    terms.push_back(std::polar(1.0, -2.0 * std::numbers::pi * lowest * at));
    turns.push_back(std::polar(1.0, -2.0 * std::numbers::pi * step * at));
  }
  Peak peak;
  for (double f = lowest; f <= widest; f += step) {
    Sum sum;
    for (std::size_t j = 0; j < terms.size(); ++j) sum += terms[j], terms[j] *= turns[j];
    if (const double size = std::abs(sum); size > peak.size) peak = {f, size};
  }
  return peak;
}

/// The greatest sum of harmonic `h` near `f`.
Peak near_by(WholeTicks ticks, double f, double h, double reach) {
  Peak peak;
  for (int k = -8; k <= 8; ++k) {
    const double at = f + reach * k / 8.0;
    if (const double size = std::abs(sum_at(ticks, h * at)); size > peak.size) peak = {at, size};
  }
  return peak;
}

/// A comb has all harmonics alike: the lowest is the period.
Peak fundamental(WholeTicks ticks, Peak peak, double length) {
  for (double part = 12.0; part > 1.5; --part)
    if (peak.f / part * length >= 1.5)
      if (const Peak lower = near_by(ticks, peak.f / part, 1.0, 0.25 / length); lower.size > 0.7 * peak.size)
        return lower;
  return peak;
}

/// As many ticks from the beginning on as the grid can be paid for.
WholeTicks payable(WholeTicks ticks, double& length) {
  constexpr double most = 1e7;  // terms of all sums
  std::size_t count = ticks.size();
  while (count > 64 && 4.0 * widest * length * static_cast<double>(count) > most) count /= 2, length = ticks[count - 1];
  return ticks.first(count);
}

/// The comb at a line of the spectrum, by its harmonics as far as they are there.
Comb sharpened(WholeTicks ticks, double length, Peak peak) {
  const double size = peak.size;
  const auto turn_of = [&](double f) { return std::arg(sum_at(ticks, f)) / (2.0 * std::numbers::pi); };
  double turn = turn_of(peak.f), h = 1.0;
  while (h < 64.0 && 4.0 * h * peak.f < 0.25) {
    const Peak finer = near_by(ticks, peak.f, 2.0 * h, 0.25 / (h * length));
    if (finer.size < 0.6 * size) break;
    h *= 2.0, peak = finer;
    const double part = turn_of(h * peak.f);
    turn = (part + std::round(h * turn - part)) / h;
  }
  Comb comb = comb_at(turn, peak.f, -1.0);
  comb.off_a = 0.2 / h, comb.off_r = 0.3 / (h * length);
  return comb;
}

}  // namespace

std::vector<Comb> comb_of_empty_ticks(WholeTicks whole) {
  constexpr std::size_t most_starts = 128, most_pairs = 4096;
  if (whole.back() > 1.5 * static_cast<double>(whole.size())) return {};
  const EmptyTicks empty = empty_ticks(whole);
  std::optional<Chain> best;
  for (std::size_t i = 0; i < std::min(empty.at.size(), most_starts); ++i)
    for (std::size_t j = i + 1; j < std::min(empty.at.size(), i + most_pairs); ++j) {
      const double period = empty.at[j] - empty.at[i];
      if (period < 1.0 / widest || !empty.near(empty.at[j] + period)) continue;
      if (best && period * static_cast<double>(best->count) > whole.back() - empty.at[i] + period) break;
      if (auto chain = chain_from(empty, empty.at[i], empty.at[j]); chain && (!best || chain->count > best->count))
        best = std::move(chain);
    }
  if (!best || best->count < fewest_teeth) return {};
  const auto [c, period] = best->teeth.middle();
  const double f = 1.0 / period;
  Comb comb = comb_at(-c * f, f, 1.0);
  comb.off_a = 2.0 * f, comb.off_r = (best->teeth.highest() - best->teeth.lowest()) * f * f * comb.r * comb.r;
  return {comb};
}

std::vector<Comb> comb_of_doubled_ticks(WholeTicks whole) {
  std::vector<double> doubled;
  for (std::size_t i = 1; i < whole.size(); ++i)
    if (whole[i] == whole[i - 1]) doubled.push_back(whole[i]);
  if (doubled.size() < fewest_teeth) return {};
  const double length = whole.back();
  double some = length;
  const WholeTicks first = payable(doubled, some);
  Peak peak = highest(first, some);
  const auto count = static_cast<double>(first.size());
  if (peak.size * peak.size / count < 2.0 + std::log(4.0 * widest * some + 1.0)) return {};
  for (; some < length; some = std::min(2.0 * some, length)) {  // the rest of the record, at the same place
    const auto end = std::ranges::upper_bound(doubled, 2.0 * some);
    peak = near_by({doubled.begin(), end}, peak.f, 1.0, 0.25 / some);
  }
  return {sharpened(doubled, length, fundamental(doubled, near_by(doubled, peak.f, 1.0, 0.25 / length), length))};
}

}  // namespace tumble
