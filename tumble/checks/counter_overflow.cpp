#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/counts.hpp"
#include "tumble/checks/support/signals.hpp"

namespace tumble::checks::counter_overflow {

namespace {

using namespace support;

/// [usual steps] that the counts before and after a jump may lie from the two ends. Nine in ten steps are usual, so
/// that fewer than one jump in ten is missed for a greater step. Chosen: a doubling asks for registers twice as large.
constexpr double steps_from_end = 4.0;
constexpr double usual = 0.9;     ///< [1] of the steps are usual
constexpr double at_rest = 0.5;   ///< [1] of the steps, of a test of positions and moves between them
constexpr double rounding = 2.0;  ///< [counts] that two counts of a quiet unit may differ by
/// [1] of the register, within which the counts come to both ends. Farther than a jump is looked for, see least_steps.
constexpr double end_part = 0.25;
/// [usual steps] in a register whose overflow shows: steps_from_end of them, and rounding, are then less than end_part.
constexpr double least_steps = steps_from_end / end_part;
/// Standard deviations, of the count of the number before, by which the last number of a register exceeds it where a
/// counter stops. Counts that stand at both equally often differ so much in 0.2 % of records: the difference of two
/// such counts has sqrt(2) times that sd. Without any at the number before, five and more at the last exceed it.
constexpr double excess_sd = 4.0;

/// [1] of a step over the end of a register, by which the step before it or the one after it may differ: a motion that
/// passes the end goes on. A motion without an overflow has its steps in the direction of the jump, and not against it.
constexpr double goes_on = 0.5;
/// [1] of the register: the greatest step over its end that is looked for. The jump back is then three quarters of it.
constexpr double greatest_step = 0.25;
constexpr std::size_t there_and_back = 2;  ///< passages that a motion has which leaves the register and comes back
/// [1] of the jumps of more than half of a register, that are passages.
constexpr double least_share = 0.5;

/// A register of so many bits, with or without sign.
struct Register {
  int bits = 0;
  double lowest = 0.0, highest = 0.0;
};

std::vector<Register> registers_of(std::span<const int> sizes) {
  std::vector<Register> all;
  for (const int bits : sizes) {
    const double size = std::ldexp(1.0, bits);
    all.push_back({bits, 0.0, size - 1.0});
    all.push_back({bits, -0.5 * size, 0.5 * size - 1.0});
  }
  return all;
}

/// Those that converters and counters usually have.
std::vector<Register> registers() {
  constexpr int bits[] = {8, 10, 12, 14, 16, 20, 24, 32};
  return registers_of(bits);
}

/// Of any number of bits: where a course shows that its counts go on over the end, the end need not be a usual one.
std::vector<Register> all_registers() {
  std::vector<int> bits(32 - 8 + 1);
  std::iota(bits.begin(), bits.end(), 8);
  return registers_of(bits);
}

struct Jumps {
  std::size_t count = 0, first = 0;
};

/// Jumps of more than half of a register over which a motion goes on: the step over the end is like one beside it.
struct Passages {
  Jumps passages;
  std::size_t jumps = 0;  ///< all of more than half of the register
};

Passages passages_in(const std::vector<double>& values, const Register& r) {
  const double size = r.highest - r.lowest + 1.0;
  Passages found;
  for (std::size_t i = 2; i + 1 < values.size(); ++i) {
    const double jump = values[i] - values[i - 1];
    if (!(std::abs(jump) > 0.5 * size)) continue;
    ++found.jumps;
    const double over = jump - std::copysign(size, jump);
    const double before = values[i - 1] - values[i - 2], after = values[i + 1] - values[i];
    const double unlike = std::min(std::abs(over - before), std::abs(over - after));
    if (!(std::abs(over) < greatest_step * size && unlike < goes_on * std::abs(over))) continue;
    if (found.passages.count++ == 0) found.passages.first = i;
  }
  return found;
}

/// Times at which the counts leave the register at one end and come back at the other, within a few usual steps.
Jumps jumps_in(const std::vector<double>& values, const Register& r, double step) {
  const double near = steps_from_end * step + rounding;
  Jumps jumps;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double a = values[i - 1], b = values[i];
    const bool over = a > r.highest - near && b<r.lowest + near, under = b> r.highest - near && a < r.lowest + near;
    if (!over && !under) continue;
    if (jumps.count++ == 0) jumps.first = i;
  }
  return jumps;
}

/// This share of the steps is smaller, on a circle of that size: a jump over the end is a small step there.
double usual_step(const std::vector<double>& values, double size, double share) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = std::abs(values[i] - values[i - 1]);
    if (std::isfinite(step)) steps.push_back(std::min(step, std::abs(size - step)));
  }
  if (steps.empty()) return 0.0;
  const auto last = steps.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(steps.size()));
  std::nth_element(steps.begin(), last, steps.end());
  return *last;
}

/// Whether the counts come near both ends of a register.
bool fills(const Spread& spread, const Register& r) {
  const double end = end_part * (r.highest - r.lowest);
  return spread.lowest >= r.lowest && spread.highest <= r.highest && spread.lowest <= r.lowest + end &&
         spread.highest >= r.highest - end;
}

Finding overflow(const Channel& channel, const Register& r, std::span<const double> counts, const Jumps& jumps) {
  return {Finding::Severity::error,
          "counter_overflow",
          {{"bits", r.bits},
           {"register", Phrase{r.lowest < 0.0 ? "signed_register" : "unsigned_register"}},
           {"counts", std::llround(counts[jumps.first])},
           {"before", std::llround(counts[jumps.first - 1])},
           {"size", std::llround(r.highest - r.lowest + 1.0)}},
          channel.name,
          {jumps.count, channel.time(jumps.first)}};
}

/// A motion that leaves a register and comes back.
std::optional<Finding> passed_over(const Channel& channel, const Spread& spread) {
  for (const Register& r : all_registers()) {
    if (!fills(spread, r)) continue;
    const double size = r.highest - r.lowest + 1.0;
    if (least_steps * (usual_step(channel.values, size, at_rest) + 1.0) > size) continue;
    const Passages found = passages_in(channel.values, r);
    if (found.passages.count >= there_and_back &&
        static_cast<double>(found.passages.count) >= least_share * static_cast<double>(found.jumps))
      return overflow(channel, r, channel.values, found.passages);
  }
  return std::nullopt;
}

std::optional<Finding> ran_over(const Channel& channel, const Spread& spread) {
  for (const Register& r : registers()) {
    if (!fills(spread, r)) continue;
    const double step = usual_step(channel.values, r.highest - r.lowest + 1.0, usual);
    // Counts that use the whole of it anyway run over it or do not: the counts do not show which.
    if (least_steps * (step + 1.0) > r.highest - r.lowest) continue;
    const Jumps jumps = jumps_in(channel.values, r, step);
    if (jumps.count == 0) continue;
    return overflow(channel, r, channel.values, jumps);
  }
  return std::nullopt;
}

/// Values of a noise that goes on over the end of a register: it is cut there, and what is missing stands at the other
/// end. Within a density there are twice as many values within twice the distance of the end, here 2 +- 0.25. Of a tail
/// that happens to reach so far there are ten times as many, and of values that stop at the end hardly more.
constexpr std::size_t at_edge = 40;
constexpr double narrowest = 4.0;  ///< [counts] that are looked at: of fewer the share of each matters
constexpr double fewest = 1.4, most = 2.6;
constexpr double alike = 2.5;  ///< how many times as dense values are at one end as at the other
/// [1] samples with a value that came before: in a record without steps hardly two are the same.
constexpr std::size_t least_again = 50;

struct Wrapped {
  Register reg;
  Jumps jumps;
};

/// Given     near    [counts] from an end of the register in which at_edge of the counts lie
///           within  how many lie within a distance [counts] of that end
/// Returned  distance over which there is one count; 0: the noise is not cut there
template <class Within>
double edge_of(double near, const Within& within) {
  near = std::max(narrowest, near);
  const double there = within(near), twice = within(2.0 * near);
  return twice > fewest * there && twice < most * there ? near / there : 0.0;
}

/// Given: sorted, present counts.
bool is_cut_at_both_ends(const std::vector<double>& sorted, const Register& r) {
  if (sorted.front() < r.lowest || sorted.back() > r.highest) return false;
  if (sorted[4 * at_edge] > 0.5 * (r.lowest + r.highest) ||
      sorted[sorted.size() - 4 * at_edge] < 0.5 * (r.lowest + r.highest))
    return false;
  const double begin = r.lowest - 0.5, end = r.highest + 0.5;
  const double down = edge_of(sorted[at_edge - 1] - begin, [&](double far) {
    return static_cast<double>(std::ranges::upper_bound(sorted, begin + far) - sorted.begin());
  });
  const double up = edge_of(end - sorted[sorted.size() - at_edge], [&](double far) {
    return static_cast<double>(sorted.end() - std::ranges::lower_bound(sorted, end - far));
  });
  return up > 0.0 && down > 0.0 && up < alike * down && down < alike * up;
}

/// Noise that is wide against the register: jumps from end to end do not stand out in it.
std::optional<Wrapped> wrapped(const std::vector<double>& counts) {
  std::vector<double> sorted;
  std::ranges::copy_if(counts, std::back_inserter(sorted), [](double v) { return std::isfinite(v); });
  if (sorted.size() < 16 * at_edge) return std::nullopt;
  std::ranges::sort(sorted);
  for (const Register& r : all_registers()) {
    if (!is_cut_at_both_ends(sorted, r)) continue;
    const double far = 0.5 * (r.highest - r.lowest);
    Jumps jumps;
    for (std::size_t i = 1; i < counts.size(); ++i)
      if (std::abs(counts[i] - counts[i - 1]) > far && jumps.count++ == 0) jumps.first = i;
    if (jumps.count > at_edge) return Wrapped{r, jumps};
  }
  return std::nullopt;
}

/// Whether a sample is three quarters of the range from the one before: seldom in noise, often where it is cut in two.
bool leaps(const std::vector<double>& values) {
  double low = INFINITY, high = -INFINITY;
  for (const double value : values) low = std::fmin(low, value), high = std::fmax(high, value);
  const double least = 0.75 * (high - low);
  return std::ranges::adjacent_find(values, [&](double a, double b) { return std::abs(b - a) > least; }) !=
         values.end();
}

/// Values of a converter: whole multiples of its step, as counts.
std::optional<Finding> wrapped_values(const Channel& channel) {
  if (channel.unit.offset() != 0.0 || channel.values.empty() || !leaps(channel.values)) return std::nullopt;
  const std::vector<double> counts = as_counts(channel.values, least_again);
  if (counts.empty()) return std::nullopt;
  const auto wide = wrapped(counts);
  return wide ? std::optional(overflow(channel, wide->reg, counts, wide->jumps)) : std::nullopt;
}

/// Counts that stay at the last number of a register, more of them than one below.
std::optional<Finding> stopped(const Channel& channel, const Spread& spread) {
  for (const Register& r : registers())
    for (const double end : {r.highest, r.lowest}) {
      if (end == 0.0 || end != (end > 0.0 ? spread.highest : spread.lowest)) continue;
      const double next = end > 0.0 ? end - 1.0 : end + 1.0;
      const auto there = std::ranges::count(channel.values, end), before = std::ranges::count(channel.values, next);
      const auto below = static_cast<double>(before);
      if (static_cast<double>(there) <= below + excess_sd * std::sqrt(below + 1.0)) continue;
      return Finding{Finding::Severity::error,
                     "counter_stopped",
                     {{"bits", r.bits},
                      {"register", Phrase{r.lowest < 0.0 ? "signed_register" : "unsigned_register"}},
                      {"counts", std::llround(end)}},
                     channel.name,
                     {static_cast<std::size_t>(there)}};
    }
  return std::nullopt;
}

Findings run(const Recording& recording, const Plan* plan) {
  Findings findings;
  for (const Channel& channel : recording.channels) {
    if (!counts_pulses(channel)) {
      if (!is_signal(channel, plan)) continue;
      if (auto finding = wrapped_values(channel)) findings.push_back(std::move(*finding));
      continue;
    }
    const Spread spread = spread_of(channel);
    if (!spread.whole) continue;
    if (auto finding = ran_over(channel, spread))
      findings.push_back(std::move(*finding));
    else if (auto passed = passed_over(channel, spread))
      findings.push_back(std::move(*passed));
    else if (auto wide = wrapped(channel.values))
      findings.push_back(overflow(channel, wide->reg, channel.values, wide->jumps));
    else if (auto other = stopped(channel, spread))
      findings.push_back(std::move(*other));
  }
  return findings;
}

}  // namespace

extern const Check counter_overflow{
    "counter_overflow", "counts or values of a converter that pass the end of their register or stop there", run};

}  // namespace tumble::checks::counter_overflow
