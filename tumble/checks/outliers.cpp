#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/bends.hpp"
#include "tumble/checks/support/segments.hpp"
#include "tumble/checks/support/texture.hpp"
#include "tumble/checks/support/turns.hpp"
#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/math/extremes.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/parallel.hpp"

namespace tumble::checks::outliers {

namespace {

using namespace support;

constexpr std::size_t block = 1024, thinning = 8, near = 24, ringing = 8;
/// [usual bends] from which on a sample is an outlier. A bend of white noise has the sd sqrt(1.5) of the noise, and the
/// distance from both neighbours, on one side of them, reaches 8 of these in fewer than 1e-12 of normal samples: no
/// record has one by chance. Doubled, an outlier of 10 to 20 noise sd would be missed.
constexpr double far = 8.0;
/// [1] of an outlier's distance, that no bend beside it reaches. Chosen: a knock rings with more than a third of its
/// peak in the next period unless its damping ratio is above 0.17. Doubled, ringing of two thirds is an outlier too.
constexpr double most_ringing = 1.0 / 3.0;
constexpr std::size_t least_samples = 16;  ///< of a channel: `ringing` on both sides of one
/// [usual bends] beyond which a sample is damaged. Chosen: a jump over the whole range of a 20-bit output whose noise
/// is one quantum. A damaged exponent or digit is farther; doubled, a few of them are outliers.
constexpr double damaged = 1e6;
/// [sample intervals] within which outliers of several channels are one event: two samples, and half of one for stamps
/// that are rounded apart.
constexpr double together_within = 2.5;

/// Whether a sample in [begin, end) may stand off its neighbours by `far` usual bends, those of every `step`-th sample.
/// Their median is compared by counting, which takes a fraction of the time that finding it does.
bool may_hold_some(const std::vector<double>& x, std::size_t begin, std::size_t end, std::size_t step) {
  constexpr double rounding = 1.0 + 1e-12;
  const double least = greatest_spike(x, begin, end) / (far * sd_of_median_size) * rounding;
  std::size_t bends = 0, less = 0;
  for (std::size_t i = begin; i < end; i += step) {
    const double b = bend(x, i);
    bends += b == b;
    less += b < least;
  }
  return bends == 0 || less > bends / 2;
}

/// The greatest bend of the samples [begin, end).
double greatest_bend(const std::vector<double>& x, std::size_t begin, std::size_t end) {
  double greatest = 0.0;
  for (std::size_t i = std::max<std::size_t>(1, begin); i < std::min(end, x.size() - 1); ++i)
    greatest = std::max(greatest, bend(x, i));  // not NaN: the comparison keeps the first
  return greatest;
}

struct Outlier {
  double time = 0.0;
  double distance = 0.0, usual = 0.0;
};

/// Whether a sample goes on the line through the two before it, or that through the two behind it, where a motion that
/// turns round has a corner.
bool is_corner(const std::vector<double>& x, std::size_t i, double within) {
  const auto goes_on = [&](double next, double second) { return std::abs(x[i] - (2.0 * next - second)) <= within; };
  return (i >= 2 && goes_on(x[i - 1], x[i - 2])) || (i + 2 < x.size() && goes_on(x[i + 1], x[i + 2]));
}

/// Samples that stand apart from both neighbours, on the same side, by eight times the usual bend: that of the block,
/// and of what comes just before and just after, so that the onset of a motion is none. A step is none either, nor is a
/// corner, nor a knock, which rings: no sample nearby may bend by a third as much.
/// Nor is what comes within `near` samples of the beginning of a segment, where the rig moves.
std::vector<Outlier> find_outliers(const Channel& channel, double quantum, const std::vector<std::size_t>& moves) {
  const std::vector<double>& x = channel.values;
  const double coarseness = 0.5 * quantum;  // the median of coarse values may be off by that
  std::vector<Outlier> found;
  std::vector<double> room;
  for (std::size_t begin = 1; begin + 1 < x.size(); begin += block) {
    const std::size_t end = std::min(begin + block, x.size() - 1);
    const std::size_t step = end - begin < block ? 1 : thinning;
    if (!may_hold_some(x, begin, end, step)) continue;
    const double usual = usual_bend(x, begin, end, step, room) + coarseness;
    for (std::size_t i = begin; i < end; ++i) {
      const double from_last = x[i] - x[i - 1], from_next = x[i] - x[i + 1];
      const double distance = std::min(std::abs(from_last), std::abs(from_next));
      if (!(distance > far * usual) || !(from_last * from_next > 0.0)) continue;  // nor beside a missing one
      const auto move = std::ranges::upper_bound(moves, i + 1);                   // the first that comes later
      if (move != moves.begin() && i < *std::prev(move) + near) continue;
      const double before = usual_bend(x, i > near + 1 ? i - near - 1 : 1, i - 1, 1, room) + coarseness;
      const double after = usual_bend(x, i + 2, i + 2 + near, 1, room) + coarseness;
      const double local = std::max({usual, before, after});
      const double rings = std::max(greatest_bend(x, i > ringing + 1 ? i - ringing - 1 : 1, i - 1),
                                    greatest_bend(x, i + 2, i + 2 + ringing));
      if (!(distance > far * local) || rings > distance * most_ringing || is_corner(x, i, far * local)) continue;
      found.push_back({channel.time(i), distance, local});
    }
  }
  return found;
}

std::vector<Outlier> outliers_of(const Channel& channel, const Recording& recording) {
  if (channel.values.size() < least_samples) return {};
  std::vector<std::size_t> moves;
  for (const Mark& mark : recording.marks)  // durations that add up are rounded
    moves.push_back(index_at(channel, mark.begin - stamp_slack(mark.begin, 1.0 / mean_rate(channel))));
  std::ranges::sort(moves);
  auto outliers = find_outliers(channel, texture_of(channel.values).quantum, moves);
  const double sample = 1.0 / mean_rate(channel);  // one that begins before a segment ends may reach into what follows
  std::erase_if(outliers, [&](const Outlier& one) {
    return is_between_segments(recording, one.time, one.time) ||
           is_between_segments(recording, one.time + sample, one.time + sample);
  });
  return outliers;
}

/// What no instrument puts out: a bit, a digit or a record that was damaged on its way.
bool is_damaged(const Outlier& outlier) { return outlier.distance > damaged * outlier.usual; }

Finding said_of(const Channel& channel, const std::vector<Outlier>& outliers) {
  const Outlier& farthest = *std::ranges::max_element(outliers, {}, &Outlier::distance);
  // A distance has no zero: that of two temperatures is in K.
  const Unit unit = channel.unit.offset() == 0.0 ? channel.unit : Unit::parse("K");
  const bool broken = is_damaged(farthest);
  return {broken ? Finding::Severity::error : Finding::Severity::warning,
          broken ? "damaged_sample" : "outlier",
          {{"distance", farthest.distance, unit}, {"times", farthest.distance / farthest.usual}},
          channel.name,
          {outliers.size(), outliers.front().time, farthest.time}};
}

/// What several channels show within a sample or two is no fault of one of them.
struct Together {
  std::vector<double> times;
  std::vector<std::string> channels;
};

/// Whether one of the outliers, which are in order of time, is closer to `time` than `close` [s].
bool is_near(const std::vector<Outlier>& outliers, double time, double close) {
  const auto next = std::ranges::lower_bound(outliers, time - close, {}, &Outlier::time);
  return next != outliers.end() && next->time < time + close;
}

/// Moves the outliers that channels have in common, within two samples, from them to `together`.
void take_common(const Recording& recording, std::vector<std::vector<Outlier>>& outliers, Together& together) {
  const auto all = outliers;
  double close = 0.0;
  for (std::size_t c = 0; c < outliers.size(); ++c) {
    if (outliers[c].empty()) continue;
    close = together_within / mean_rate(recording.channels[c]);
    const auto is_alone = [&](const Outlier& one) {
      for (std::size_t other = 0; other < all.size(); ++other)
        if (other != c && is_near(all[other], one.time, close)) return false;
      return true;
    };
    const auto common = std::ranges::stable_partition(outliers[c], is_alone);
    if (common.empty()) continue;
    together.channels.push_back(recording.channels[c].name);
    for (const Outlier& one : common) together.times.push_back(one.time);
    outliers[c].erase(common.begin(), common.end());
  }
  std::ranges::sort(together.times);
  const auto again = std::ranges::unique(together.times, [&](double a, double b) { return b - a < close; });
  together.times.erase(again.begin(), again.end());
}

Findings run(const Recording& recording, const Plan*) {
  std::vector<std::vector<Outlier>> outliers(recording.channels.size());
  parallel_for(outliers.size(), [&](std::size_t c) {
    const auto turned = without_wraps(recording.channels[c]);
    outliers[c] = outliers_of(turned ? *turned : recording.channels[c], recording);
  });
  Together together;
  take_common(recording, outliers, together);
  Findings findings;
  for (std::size_t c = 0; c < outliers.size(); ++c) {
    const auto usual = std::ranges::stable_partition(outliers[c], is_damaged);
    for (const auto& part : {std::vector(outliers[c].begin(), usual.begin()), std::vector(usual.begin(), usual.end())})
      if (!part.empty()) findings.push_back(said_of(recording.channels[c], part));
  }
  if (together.times.empty()) return findings;
  findings.push_back({Finding::Severity::info,
                      "outliers_together",
                      {{"channels", fmt::format("{}", fmt::join(together.channels, ", "))}},
                      "",
                      {together.times.size(), together.times.front(), together.times.front()}});
  return findings;
}

}  // namespace

extern const Check outliers{"outliers", "single samples far from both neighbours", run};

}  // namespace tumble::checks::outliers
