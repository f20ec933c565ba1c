#include <algorithm>
#include <cmath>
#include <vector>

#include "tumble/checks/check.hpp"
#include "tumble/checks/grain.hpp"
#include "tumble/checks/support/bends.hpp"
#include "tumble/checks/support/each_channel.hpp"
#include "tumble/checks/support/signals.hpp"
#include "tumble/checks/support/texture.hpp"

namespace tumble::checks::zeros {

namespace {

using namespace support;

constexpr std::size_t least = 8;  ///< samples of exactly zero that are looked at
/// [1] of the frequency of the values beside zero. Chosen: in noise of 0.4 steps zero is 8 times as frequent as the next
/// value, and an output with more is coarse by another check.
constexpr double excess = 10.0;
/// [steps] of an output without values between itself and zero: the nearest of them is farther than that.
constexpr double least_hole = 3.0, least_hole_of_counts = 2.0;
/// Logarithm of the chance that none of the values nearest to zero lies in the hole, all places up to the last of them being
/// alike: exp(-20) is 2e-9.
constexpr double chance_of_hole = 20.0;
/// [rms of what neighbours do not predict] that both neighbours of a zero lie away from it, on one side, where it was
/// written in place of a sample. Noise passes from there to zero and back in 1e-6 of samples.
constexpr double far = 5.0;
/// Values nearest to zero whose density tells: a quarter of the zeros, so that they lie close to it, 64 at least.
constexpr std::size_t beside = 64, part = 4;
/// [sd of a sample about its neighbours, and residuals of two neighbours on either side from their line] that a single zero
/// lies away from that line, where no count comes by itself: eight of noise have p = 1e-15.
constexpr double far_alone = 8.0;
constexpr std::size_t changes = 12;    ///< from a zero to another value and back, that counts show
constexpr std::size_t at_borders = 4;  ///< such changes at the beginning and end of a segment that may rest at zero

/// Samples that are exactly zero, and what lies beside them.
struct Zeros {
  std::size_t count = 0, first = 0;
  std::size_t alone = 0;             ///< between two values far away on one side
  std::size_t changes = 0;           ///< of neighbours from zero to another value, or back
  double nearest_change = INFINITY;  ///< [u] least size of such a value
};

Zeros zeros_of(const std::vector<double>& x, double scatter) {
  Zeros zeros;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (x[i] != 0.0) continue;
    if (zeros.count++ == 0) zeros.first = i;
    const double before = i > 0 ? x[i - 1] : NAN, after = i + 1 < x.size() ? x[i + 1] : NAN;
    for (const double other : {before, after})
      if (std::abs(other) > 0.0)
        ++zeros.changes, zeros.nearest_change = std::min(zeros.nearest_change, std::abs(other));
    zeros.alone += before * after > 0.0 && std::min(std::abs(before), std::abs(after)) > far * scatter;
  }
  return zeros;
}

/// The values nearest to zero.
struct Nearest {
  double first = 0.0, last = 0.0;  ///< [u] sizes
  double count = 0.0;
  double of_each = 0.0;  ///< samples that share the commonest of these values
  double step = 0.0;     ///< [u] mean distance of different sizes
};

Nearest nearest_to_zero(const std::vector<double>& x, std::size_t zeros) {
  std::vector<double> sizes;
  for (const double value : x)
    if (std::abs(value) > 0.0) sizes.push_back(std::abs(value));
  if (sizes.empty()) return {};
  const std::size_t count = std::min(sizes.size(), std::max(zeros / part, beside));
  const auto last = sizes.begin() + static_cast<std::ptrdiff_t>(count - 1);
  std::nth_element(sizes.begin(), last, sizes.end());
  sizes.resize(count);
  std::ranges::sort(sizes);
  double different = 1.0, alike = 1.0, most_alike = 1.0;
  for (std::size_t i = 1; i < count; ++i) {
    const bool same = sizes[i] == sizes[i - 1];
    different += same ? 0.0 : 1.0;
    alike = same ? alike + 1.0 : 1.0;
    most_alike = std::max(most_alike, alike);
  }
  const double step = different > 1.0 ? (sizes.back() - sizes.front()) / (different - 1.0) : 0.0;
  return {sizes.front(), sizes.back(), static_cast<double>(count), 0.5 * most_alike, step};  // a size has two signs
}

constexpr double almost_all = 1.0 - 1e-9;  ///< [1] of the places, where the nearest values are all one

/// Whether there is no value between zero and the nearest one, though there is room for many.
bool leaves_hole(const Nearest& nearest, double step, double least_steps) {
  if (!(nearest.first >= least_steps * step)) return false;
  return -nearest.count * std::log1p(-std::min((nearest.first - step) / nearest.last, almost_all)) > chance_of_hole;
}

/// Whether zero is a value of an output in steps, next to a step away: most changes from zero lead to the first step, and the
/// next value is about as far from that. Steps need not be equal on both sides.
bool is_a_step(const std::vector<double>& x, double first) {
  constexpr double beside_step = 1.5, next_step = 3.0;  // [steps]
  double to_first = 0.0, all = 0.0, next = INFINITY;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (const double size = std::abs(x[i]); size > beside_step * first) next = std::min(next, size);
    if (i == 0 || !((x[i] == 0.0) != (x[i - 1] == 0.0)) || std::isnan(x[i]) || std::isnan(x[i - 1])) continue;
    all += 1.0;
    to_first += std::abs(x[i] + x[i - 1]) <= beside_step * first ? 1.0 : 0.0;
  }
  return 2.0 * to_first > all && next < next_step * first;
}

Finding dead_band(const Channel& channel, const Zeros& zeros, double edge) {
  return {Finding::Severity::warning,
          "no_value_near_zero",
          {{"zeros", zeros.count}, {"edge", edge, channel.unit}},
          channel.name,
          {zeros.count, channel.time(zeros.first)}};
}

Finding in_place_of_samples(const Channel& channel, const Zeros& zeros) {
  return {Finding::Severity::warning,
          "zeros_in_place_of_samples",
          {{"part", static_cast<double>(zeros.count) / static_cast<double>(channel.values.size()), "%"}},
          channel.name,
          {zeros.count, channel.time(zeros.first)}};
}

/// Whether one and two are as frequent as zero, within `excess`: a count of few pulses a sample falls to zero by itself.
bool counts_down_to_zero(const std::vector<double>& x, const Zeros& zeros) {
  const auto beside_zero = [](double value) { return std::abs(value) > 0.0 && std::abs(value) <= 2.0; };
  const auto of_each = 0.5 * static_cast<double>(std::ranges::count_if(x, beside_zero));
  return static_cast<double>(zeros.count) <= static_cast<double>(least) + excess * of_each;
}

/// Whether a count of zero interrupts a course: the two before it and the two after it lie on a line that is far away.
bool interrupts(const std::vector<double>& x, std::size_t i, double scatter) {
  if (x[i] != 0.0 || i < 2 || i + 2 >= x.size()) return false;
  const double a = x[i - 2], b = x[i - 1], c = x[i + 1], d = x[i + 2];
  const double here = 0.25 * (a + b + c + d), slope = (2.0 * (d - a) + c - b) / 10.0;
  const double residual = std::max({std::abs(a - here + 2.0 * slope), std::abs(b - here + slope),
                                    std::abs(c - here - slope), std::abs(d - here - 2.0 * slope)});
  return a * d > 0.0 && b * c > 0.0 && std::abs(here) > far_alone * std::max({residual, scatter, 1.0});
}

/// Zeros that interrupt a course.
Zeros interruptions(const std::vector<double>& x) {
  Zeros zeros;
  std::vector<double> room;
  const double scatter = usual_bend(x, 1, x.size(), 1, room);
  for (std::size_t i = 0; i < x.size(); ++i)
    if (interrupts(x, i, scatter) && zeros.count++ == 0) zeros.first = i;
  return zeros;
}

/// Whether all counts are multiples of one of them: zero is one of their steps.
bool are_multiples(const std::vector<double>& x, double of) {
  return std::ranges::all_of(x, [&](double value) { return std::isnan(value) || std::fmod(value, of) == 0.0; });
}

/// Counts that change between zero and values of two and more, but never to one.
Findings of_counts(const Channel& channel, const Zeros& zeros, std::size_t segments) {
  if (zeros.alone * 2 > zeros.count && !counts_down_to_zero(channel.values, zeros))
    return {in_place_of_samples(channel, zeros)};
  if (zeros.changes < changes + at_borders * segments) return {};
  const Nearest nearest = nearest_to_zero(channel.values, zeros.count);
  if (nearest.first < least_hole_of_counts || zeros.nearest_change > 2.0 * nearest.first ||
      !leaves_hole(nearest, 1.0, least_hole_of_counts) || are_multiples(channel.values, nearest.first))
    return {};
  return {dead_band(channel, zeros, nearest.first)};
}

/// Whether a motion may rest at zero so often: at the borders of segments only.
bool may_rest(const Zeros& zeros, std::size_t segments) {
  return zeros.alone < least && zeros.changes < changes + at_borders * segments;
}

Findings of_values(const Channel& channel, const Zeros& zeros, std::size_t segments) {
  if (!texture_of(channel.values).noisy && may_rest(zeros, segments)) return {};
  const Nearest nearest = nearest_to_zero(channel.values, zeros.count);
  if (!(static_cast<double>(zeros.count) > static_cast<double>(least) + excess * nearest.of_each)) return {};
  if (2 * zeros.alone < zeros.count && leaves_hole(nearest, nearest.step, least_hole))
    return {dead_band(channel, zeros, nearest.first)};
  if (2 * zeros.alone < zeros.count && is_a_step(channel.values, nearest.first)) return {};
  return {in_place_of_samples(channel, zeros)};
}

Findings look_at(const Channel& channel, std::size_t segments) {
  const auto count = static_cast<std::size_t>(std::ranges::count(channel.values, 0.0));
  if (count == 0 || count == channel.values.size()) return {};
  if (channel.kind == QuantityKind::count)
    if (const Zeros single = interruptions(channel.values); single.count > 0)
      return {in_place_of_samples(channel, single)};
  if (count < least) return {};
  const Grain grain = grain_of(channel.values);
  if (channel.kind != QuantityKind::count && is_coarse(grain)) return {};  // zero is one of few values
  const Zeros zeros = zeros_of(channel.values, grain.scatter);
  return channel.kind == QuantityKind::count ? of_counts(channel, zeros, segments)
                                             : of_values(channel, zeros, segments);
}

Findings run(const Recording& recording, const Plan* plan) {
  return findings_of_each(recording, [&](const Channel& channel) {
    return is_signal(channel, plan) ? look_at(channel, recording.marks.size()) : Findings{};
  });
}

}  // namespace

extern const Check zeros{"zeros", "zeros in place of samples, and outputs that show no small value but zero", run};

}  // namespace tumble::checks::zeros
