#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/texture.hpp"
#include "tumble/core/say.hpp"

namespace tumble::checks {

namespace {

struct Stuck {
  std::size_t times = 0, samples = 0, longest = 0, longest_begin = 0;
};

/// Runs this long come by chance once in a million records of this size: n p^(length - 1) < 1e-6.
std::size_t improbable_length(std::size_t size, double repeats) {
  const double chance = std::clamp(repeats, 1e-3, 0.99);
  const double length = 1.0 + std::log(1e6 * static_cast<double>(size)) / -std::log(chance);
  return std::max<std::size_t>(8, static_cast<std::size_t>(std::ceil(length)));
}

/// Whether the samples on both sides of a run are noisy and so seldom repeat that the run cannot be chance: a signal
/// may be noisy elsewhere and too coarse to move here.
bool out_of_place(std::span<const double> values, std::size_t begin, std::size_t length) {
  constexpr std::size_t side = 128, enough = 32;
  const std::size_t first = begin > side ? begin - side : 0, end = begin + length;
  for (const auto stretch :
       {values.subspan(first, begin - first), values.subspan(end, std::min(side, values.size() - end))}) {
    if (stretch.size() < enough) continue;
    const Texture texture = texture_of(stretch);
    if (!texture.noisy || length < improbable_length(values.size(), texture.equal_neighbours)) return false;
  }
  return true;
}

/// Runs of equal values of at least `shortest` samples, those at the channel's extremes left to the saturation check.
Stuck stuck_runs(const std::vector<double>& values, std::size_t shortest, double lowest, double highest) {
  Stuck stuck;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= values.size(); ++i) {
    if (i < values.size() && values[i] == values[begin]) continue;
    const std::size_t length = i - begin;
    if (length >= shortest && values[begin] != lowest && values[begin] != highest &&
        out_of_place(values, begin, length)) {
      ++stuck.times;
      stuck.samples += length;
      if (length > stuck.longest) stuck.longest = length, stuck.longest_begin = begin;
    }
    begin = i;
  }
  return stuck;
}

bool carries_the_answer(QuantityKind kind) {
  return kind == QuantityKind::angular_rate || kind == QuantityKind::specific_force || kind == QuantityKind::velocity;
}

Findings look_at(const Channel& channel) {
  double lowest = INFINITY, highest = -INFINITY;
  std::size_t present = 0;
  for (const double value : channel.values) {
    lowest = std::min(lowest, std::isnan(value) ? lowest : value);
    highest = std::max(highest, std::isnan(value) ? highest : value);
    present += !std::isnan(value);
  }
  if (present < 2) return {};
  if (lowest == highest) {
    const bool matters = carries_the_answer(channel.kind) || channel.kind == QuantityKind::count;
    return {{matters ? Finding::Severity::error : Finding::Severity::info,
             "constant: " + say_value(lowest, channel.unit) + " throughout", channel.name}};
  }
  const Texture texture = texture_of(channel.values);
  if (!texture.noisy) return {};
  const std::size_t shortest = improbable_length(channel.values.size(), texture.repeats);
  const Stuck stuck = stuck_runs(channel.values, shortest, lowest, highest);
  if (stuck.times == 0) return {};
  const double length = channel.time(stuck.longest_begin + stuck.longest - 1) - channel.time(stuck.longest_begin);
  return {
      {Finding::Severity::warning,
       fmt::format("stuck {} ({} in all), the longest {} at {}",
                   stuck.times == 1 ? "once" : fmt::format("{} times", stuck.times), say_count(stuck.samples, "sample"),
                   say_seconds(length), say_instant(channel.time(stuck.longest_begin))),
       channel.name}};
}

Findings run(const Recording& recording, const Plan*) {
  Findings findings;
  for (const Channel& channel : recording.channels)
    for (auto& finding : look_at(channel)) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace

extern const Check stuck_output;
const Check stuck_output{"stuck_output", "a noisy channel that repeats one value, or a channel that never changes",
                         run};

}  // namespace tumble::checks
