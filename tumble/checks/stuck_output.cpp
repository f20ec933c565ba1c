#include <algorithm>
#include <cmath>

#include "tumble/checks/check.hpp"
#include "tumble/checks/grain.hpp"
#include "tumble/checks/support/each_channel.hpp"
#include "tumble/checks/support/signals.hpp"
#include "tumble/checks/support/texture.hpp"
#include "tumble/math/extremes.hpp"

namespace tumble::checks::stuck_output {

namespace {

using namespace support;

constexpr double records_per_false_alarm = 1e6;  ///< of the size of this one, until one has such a run by chance
/// [1] of samples that equal the one before. Below, the length would hang on a share that 1000 samples do not show;
/// above, it would grow without bound: at 0.99 it is 2750 of a million samples.
constexpr double least_repeats = 1e-3, most_repeats = 0.99;
/// Equal samples in a row that are looked at. Chosen: where few samples repeat, the probability alone accepts 5 in a
/// row of a million. Doubled, faults shorter than 16 samples are missed.
constexpr std::size_t least_length = 8;
constexpr double one_step = 1.5;    ///< [counts] rounding moves a count by 1, and this is more
constexpr std::size_t enough = 32;  ///< samples beside a run that show what is usual: twice what `texture_of` needs

struct Stuck {
  std::size_t times = 0, samples = 0, longest = 0, longest_begin = 0;
};

/// Runs this long come once in a million records of this size: n p^(length - 1) < 1/records_per_false_alarm.
std::size_t improbable_length(std::size_t size, double repeats) {
  const double chance = std::clamp(repeats, least_repeats, most_repeats);
  const double length = 1.0 + std::log(records_per_false_alarm * static_cast<double>(size)) / -std::log(chance);
  return std::max<std::size_t>(least_length, static_cast<std::size_t>(std::ceil(length)));
}

/// Whether most steps between neighbouring counts are greater than rounding makes them. Windows of one running total
/// round together: while it lies within a pulse they repeat for long, and at its edge they flicker by +-1.
bool beyond_rounding(std::span<const double> counts) {
  std::size_t large = 0, steps = 0;
  for (std::size_t i = 1; i < counts.size(); ++i)
    if (const double step = std::abs(counts[i] - counts[i - 1]); !std::isnan(step)) large += step > one_step, ++steps;
  return 2 * large > steps;
}

/// Whether the samples on both sides of a run are noisy and so seldom repeat that the run cannot be chance: a signal
/// may be noisy elsewhere and too coarse to move here.
bool out_of_place(std::span<const double> values, std::size_t begin, std::size_t length, bool counts) {
  constexpr std::size_t side = 128;
  const std::size_t first = begin > side ? begin - side : 0, end = begin + length;
  for (const auto stretch :
       {values.subspan(first, begin - first), values.subspan(end, std::min(side, values.size() - end))}) {
    if (stretch.size() < enough) continue;
    const Texture texture = texture_of(stretch);
    if (!texture.noisy || length < improbable_length(values.size(), texture.equal_neighbours)) return false;
    if (counts && !beyond_rounding(stretch)) return false;
  }
  return true;
}

/// Where the stretches of samples begin with which a run is compared, and the end of all: the whole channel, but of
/// counts the segments. How often counts repeat depends on the part of a pulse that is left over at what is felt there,
/// not on the noise alone.
std::vector<std::size_t> borders_of(const Channel& channel, const std::vector<Mark>& marks) {
  std::vector<std::size_t> borders{0, channel.values.size()};
  if (channel.kind == QuantityKind::count)
    for (const auto& mark : marks) borders.push_back(std::min(index_at(channel, mark.begin), channel.values.size()));
  std::ranges::sort(borders);
  return borders;
}

/// Whether a run is out of place in a segment of those that it covers. In one that it fills nearly whole it is not: a
/// quiet unit at rest counts alike for long.
bool out_of_place_in_segment(std::span<const double> values, const std::vector<std::size_t>& borders, std::size_t begin,
                             std::size_t length, bool counts) {
  const std::size_t end = begin + length;
  while (begin < end) {
    const auto last = std::ranges::upper_bound(borders, begin);
    const std::size_t from = *std::prev(last), to = *last, part = std::min(end, to) - begin;
    const bool fills = borders.size() > 2 && from + enough > begin && begin + part + enough > to;
    if (!fills && out_of_place(values.subspan(from, to - from), begin - from, part, counts)) return true;
    begin += part;
  }
  return false;
}

/// Whether counts move by more than rounding right beside a run: in the nodes of a beat whole pulses stay the same.
bool breaks_off(std::span<const double> values, std::size_t begin, std::size_t length) {
  constexpr std::size_t side = 8;
  const auto moves = [&](std::size_t from, std::size_t to) {
    double steps = 0.0, n = 0.0;
    for (std::size_t i = from + 1; i < to; ++i)
      if (const double step = std::abs(values[i] - values[i - 1]); !std::isnan(step)) steps += step, ++n;
    return steps > one_step * n;
  };
  const std::size_t end = begin + length;
  return moves(begin > side ? begin - side : 0, begin) || moves(end, std::min(values.size(), end + side));
}

/// Calls visit(begin, length) for every run of equal values of at least `shortest` samples. So long a run holds one of
/// the pairs of neighbours that lie shortest - 1 apart: only these are looked at.
template <class Visit>
void visit_runs(const std::vector<double>& values, std::size_t shortest, Visit visit) {
  std::size_t done = 0;
  for (std::size_t i = shortest - 1; i < values.size(); i += shortest - 1) {
    if (i < done || values[i] != values[i - 1]) continue;
    std::size_t begin = i - 1, end = i + 1;
    while (begin > 0 && values[begin - 1] == values[i]) --begin;
    while (end < values.size() && values[end] == values[i]) ++end;
    if (end - begin >= shortest) visit(begin, end - begin);
    done = end;
  }
}

/// Runs of equal values of at least `shortest` samples, those at the channel's extremes left to the saturation check.
Stuck stuck_runs(const Channel& channel, const std::vector<std::size_t>& borders, std::size_t shortest, double lowest,
                 double highest) {
  const std::vector<double>& values = channel.values;
  const bool counts = channel.kind == QuantityKind::count;
  Stuck stuck;
  visit_runs(values, shortest, [&](std::size_t begin, std::size_t length) {
    if (values[begin] == lowest || values[begin] == highest ||
        !out_of_place_in_segment(values, borders, begin, length, counts) ||
        (counts && !breaks_off(values, begin, length)))
      return;
    ++stuck.times;
    stuck.samples += length;
    if (length > stuck.longest) stuck.longest = length, stuck.longest_begin = begin;
  });
  return stuck;
}

bool carries_the_answer(QuantityKind kind) {
  return kind == QuantityKind::angular_rate || kind == QuantityKind::specific_force || kind == QuantityKind::velocity;
}

/// Runs of one value in a noisy channel. A temperature may be noisy too, an angle stands still where its axis does.
bool may_be_stuck(const Channel& channel, const Plan* plan) {
  return is_signal(channel, plan) || channel.kind == QuantityKind::temperature || channel.kind == QuantityKind::other;
}

Findings look_at(const Channel& channel, const std::vector<Mark>& marks, bool one_segment, bool runs) {
  const auto [lowest, highest, present, at_lowest, at_highest] = extremes_of(channel.values);
  if (present < 2) return {};
  if (lowest == highest) {
    // the file of one position of a quiet unit may well hold the same count throughout
    const bool matters = carries_the_answer(channel.kind) || (channel.kind == QuantityKind::count && !one_segment);
    return {{matters ? Finding::Severity::error : Finding::Severity::info,
             "constant_output",
             {{"value", lowest, channel.unit}},
             channel.name}};
  }
  if (!runs) return {};
  const Texture texture = texture_of(channel.values);
  if (!texture.noisy) return {};
  const std::size_t shortest = improbable_length(channel.values.size(), texture.repeats);
  const Stuck stuck = stuck_runs(channel, borders_of(channel, marks), shortest, lowest, highest);
  if (stuck.times == 0) return {};
  if (channel.kind != QuantityKind::count && is_coarse(grain_of(channel.values)))
    return {};  // rests at one of its steps
  const double length = channel.time(stuck.longest_begin + stuck.longest - 1) - channel.time(stuck.longest_begin);
  return {{Finding::Severity::warning,
           "stuck_output",
           {{"samples", stuck.samples}, {"longest", length, "s"}},
           channel.name,
           {stuck.times, {}, channel.time(stuck.longest_begin)}}};
}

bool holds_one_segment(const Recording& recording, const Plan* plan) {
  return plan && std::ranges::any_of(plan->recordings, [&](const RecordingEntry& entry) {
           return entry.file == recording.origin.file && !entry.segment.empty();
         });
}

Findings run(const Recording& recording, const Plan* plan) {
  const bool one_segment = holds_one_segment(recording, plan);
  return findings_of_each(recording, [&](const Channel& channel) {
    return look_at(channel, recording.marks, one_segment, may_be_stuck(channel, plan));
  });
}

}  // namespace

extern const Check stuck_output{"stuck_output",
                                "a noisy channel that repeats one value, or a channel that never changes", run};

}  // namespace tumble::checks::stuck_output
