#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "tumble/checks/check.hpp"
#include "tumble/checks/grain.hpp"
#include "tumble/checks/support/each_channel.hpp"
#include "tumble/checks/support/signals.hpp"
#include "tumble/checks/support/texture.hpp"
#include "tumble/math/extremes.hpp"
#include "tumble/math/median.hpp"

namespace tumble::checks::saturation {

namespace {

using namespace support;

constexpr std::size_t least_at_extreme = 10;  ///< samples at the extreme value, below which none is called a pile
/// The tail of noise thins out: its last value is less frequent than the one before. A pile exceeds that by half, and
/// by four times the square root, which is the scatter of a count. None of 38 000 ends of simulated white noise did
/// (1000 to 100 000 samples, a quantum of 0.5 to 2 sd).
constexpr double pile_ratio = 1.5, pile_sd = 4.0;
/// [quanta] of the step that runs into a plateau: near its peak a smooth oscillation that fills `wide_range` moves by
/// less from one sample to the next. Chosen: doubled, clipped tones of a small amplitude are missed.
constexpr double abrupt_step = 4.0;
constexpr double wide_range = 2.0 * abrupt_step;  ///< [quanta] from lowest to highest: room for two such steps
constexpr std::size_t least_plateaus = 10, least_in_plateaus = 20;  ///< and their samples: each has two
constexpr double one_step = 1.5;  ///< [quanta, pulses] less than this is one step or none
constexpr std::size_t no_peak =
    32;  ///< samples in a row that no peak of a noisy tone has; a motion runs into a clipped segment
/// [pulses] of the median change in the usual segment, from which on no position counts alike by itself: rounding moves
/// neighbours by one.
constexpr double noisy_change = 2.0;
/// [1] of the neighbours that are alike in the usual segment, below which the noise is above 0.75 pulses: no position of such
/// a unit shows the same count 24 times in a row, wherever between two counts it lies (0.4^23 = 7e-10).
constexpr double most_alike = 0.35;
constexpr std::size_t never_alike = 24;
/// [1] of the pairs of places that are alike where the peak of a tone repeats with the samples: two patterns at equal
/// shares give 0.5. What is cut off stands between all kinds of values, which gives next to none: half of 0.5
/// separates.
constexpr double pattern_share = 0.25;

/// The end of a channel's range: how often the extreme value stands there, and how often the one next to it.
struct End {
  double extreme = -INFINITY, next = -INFINITY;  // of sign * value
  std::size_t at_extreme = 0, at_next = 0;

  void add(double value) {
    if (value < next) return;
    if (value > extreme) {
      next = extreme, at_next = at_extreme;
      extreme = value, at_extreme = 1;
    } else if (value == extreme) {
      ++at_extreme;
    } else if (value > next) {
      next = value, at_next = 1;
    } else {
      at_next += value == next;  // not NaN
    }
  }
};

/// Noise ends in a thin tail: where its last value is commoner than the one before, something cut it off.
bool piled_up(const End& end) {
  const auto next = static_cast<double>(end.at_next);
  return end.at_extreme >= least_at_extreme &&
         static_cast<double>(end.at_extreme) > pile_ratio * next + pile_sd * std::sqrt(next);
}

/// Times at which the signal runs into its extreme value by a step of more than `abrupt_step` and stays there for
/// `length` samples and more: a clipped oscillation. A smooth one slows down before it turns.
std::size_t abrupt_plateaus(const std::vector<double>& values, double extreme, double quantum, std::size_t length) {
  std::size_t plateaus = 0;
  for (std::size_t i = 1; i + length <= values.size(); ++i) {
    bool stays = std::abs(values[i] - values[i - 1]) > abrupt_step * quantum;
    for (std::size_t k = 0; k < length && stays; ++k) stays = values[i + k] == extreme;
    plateaus += stays;
  }
  return plateaus;
}

/// Samples of the longest run of a value.
std::size_t longest_run(const std::vector<double>& values, double value) {
  std::size_t longest = 0, run = 0;
  for (const double one : values) {
    run = one == value ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  return longest;
}

/// Whether the extreme value comes with the same neighbours to the quantum again and again, as in an oscillation that
/// repeats with the samples (50 Hz at 200 a second) and whose peak, or the two samples about it, is the same number
/// every time. What is cut off stands between all kinds of values. Judged by 256 of the places at most.
bool comes_in_one_pattern(const std::vector<double>& values, double extreme, double quantum) {
  constexpr std::size_t most = 256;
  std::vector<std::size_t> places;
  for (std::size_t i = 1; i + 1 < values.size(); ++i)
    if (values[i] == extreme && !(values[i - 1] == extreme && values[i + 1] == extreme)) places.push_back(i);
  const std::size_t stride = places.size() / most + 1;
  std::size_t alike = 0, pairs = 0;
  const auto close = [&](std::size_t i, std::size_t j) { return std::abs(values[i] - values[j]) < one_step * quantum; };
  for (std::size_t a = 0; a < places.size(); a += stride)
    for (std::size_t b = a + stride; b < places.size(); b += stride) {
      const std::size_t i = places[a], j = places[b];
      ++pairs;
      alike += close(i - 1, j - 1) && close(i + 1, j + 1);
    }
  return pairs > 0 && static_cast<double>(alike) > pattern_share * static_cast<double>(pairs);
}

/// The samples of each segment.
std::vector<std::span<const double>> segments_of(const Channel& channel, const std::vector<Mark>& marks) {
  std::vector<std::span<const double>> segments;
  const std::size_t size = channel.values.size();
  for (std::size_t m = 0; m < marks.size(); ++m) {
    const std::size_t begin = std::min(index_at(channel, marks[m].begin), size);
    const std::size_t end = m + 1 < marks.size() ? std::min(index_at(channel, marks[m + 1].begin), size) : size;
    segments.push_back(std::span(channel.values).subspan(begin, std::max(begin, end) - begin));
  }
  return segments;
}

/// How neighbours in the usual segment differ.
struct Changes {
  double median = 0.0;  ///< [u]
  double alike = 1.0;   ///< [1] share of those that are the same
};

Changes usual_changes(const std::vector<std::span<const double>>& segments) {
  std::vector<double> changes, alike;
  for (const auto& values : segments) {
    std::vector<double> own;
    for (std::size_t i = 1; i < values.size(); ++i)
      if (const double change = std::abs(values[i] - values[i - 1]); !std::isnan(change)) own.push_back(change);
    if (own.empty()) continue;
    alike.push_back(static_cast<double>(std::ranges::count(own, 0.0)) / static_cast<double>(own.size()));
    changes.push_back(median(std::move(own)));
  }
  if (changes.empty()) return {};
  return {median(std::move(changes)), median(std::move(alike))};
}

/// Counts of a position that a quiet unit shows, all the same but for one pulse: no pile at the end of a range. Whether
/// that is what the position should show is for the method to judge. A unit whose other positions are noisy is not quiet.
bool quiet_position(const Channel& channel, const std::vector<Mark>& marks, double extreme) {
  if (channel.kind != QuantityKind::count || marks.empty()) return false;
  const auto segments = segments_of(channel, marks);
  const double pulse = channel.unit.factor();
  const Changes usual = usual_changes(segments);
  if (usual.median > noisy_change * pulse) return false;
  if (usual.alike < most_alike && longest_run(channel.values, extreme) >= never_alike) return false;
  std::size_t there = 0, near = 0, all = 0;
  for (const auto& values : segments) {
    const auto at = static_cast<std::size_t>(std::ranges::count(values, extreme));
    if (at <= there) continue;
    there = at, all = values.size();
    near = static_cast<std::size_t>(
        std::ranges::count_if(values, [&](double v) { return std::abs(v - extreme) <= one_step * pulse; }));
  }
  return 2 * near > all;
}

Finding finding(const Channel& channel, double extreme, std::size_t count, bool highest) {
  const auto first = static_cast<std::size_t>(std::ranges::find(channel.values, extreme) - channel.values.begin());
  return {Finding::Severity::warning,
          highest ? "saturated_highest" : "saturated_lowest",
          {{"part", static_cast<double>(count) / static_cast<double>(channel.values.size()), "%"},
           {"value", extreme, channel.unit}},
          channel.name,
          {count, channel.time(first)}};
}

Findings look_at(const Channel& channel, const std::vector<Mark>& marks) {
  Findings findings;
  const Extremes ends = extremes_of(channel.values);
  if (ends.at_highest < least_at_extreme && ends.at_lowest < least_at_extreme) return findings;
  End high, low;
  for (const double value : channel.values) {
    high.add(value);
    low.add(-value);
  }
  const Texture texture = texture_of(channel.values);
  // where a position keeps to one of few values, this is no pile
  const bool shows_noise =
      texture.noisy && (channel.kind == QuantityKind::count || !is_coarse(grain_of(channel.values)));
  const bool wide = high.extreme + low.extreme > wide_range * texture.quantum;
  for (const auto& [end, sign] : {std::pair{high, 1.0}, std::pair{low, -1.0}}) {
    const double extreme = sign * end.extreme;
    if (!wide) continue;
    const auto plateaus = [&](std::size_t length) {
      return end.at_extreme >= least_in_plateaus &&
             abrupt_plateaus(channel.values, extreme, texture.quantum, length) >= least_plateaus;
    };
    const bool piled = shows_noise && piled_up(end) && !quiet_position(channel, marks, extreme);
    const bool cut_off = piled || plateaus(2);
    const bool long_pile = piled && longest_run(channel.values, extreme) >= no_peak;
    if (cut_off && (long_pile || plateaus(3) || !comes_in_one_pattern(channel.values, extreme, texture.quantum)))
      findings.push_back(finding(channel, extreme, end.at_extreme, sign > 0.0));
  }
  return findings;
}

/// An angle rests at the end of its travel, and a set point at its highest value: neither has a range that ends there.
Findings run(const Recording& recording, const Plan* plan) {
  return findings_of_each(recording, [&](const Channel& channel) {
    const bool has_range =
        is_signal(channel, plan) || channel.kind == QuantityKind::temperature || channel.kind == QuantityKind::other;
    return has_range ? look_at(channel, recording.marks) : Findings{};
  });
}

}  // namespace

extern const Check saturation{"saturation", "samples that accumulate at the end of the channel's range", run};

}  // namespace tumble::checks::saturation
