#include "tumble/reduce/arrival_stamps.hpp"

#include <algorithm>
#include <limits>
#include <map>

#include "tumble/clocks/clock.hpp"

namespace tumble {
namespace {

/// [sample intervals] between two stamps with nothing lost: the place of one sample is empty, and another place holds two.
constexpr double of_a_burst = 2.0;

/// The slope [s] of the stamps before the pauses, which are those of the samples that waited least: the saw-tooth of the others
/// would tilt a line through all. Given: interval [s] by all stamps.
double interval_of_bursts(const Channel& channel, double interval) {
  double count = 0.0, mean_i = 0.0, mean_r = 0.0, ii = 0.0, ir = 0.0;
  for (std::size_t i = 0; i + 1 < channel.values.size(); ++i) {
    if (!(channel.time(i + 1) - channel.time(i) > of_a_burst * interval)) continue;
    const auto index = static_cast<double>(i);
    const double departure = channel.time(i) - channel.time(0) - index * interval;
    const double di = index - mean_i, dr = departure - mean_r;
    ++count;
    mean_i += di / count;
    mean_r += dr / count;
    ii += di * (index - mean_i);
    ir += di * (departure - mean_r);
  }
  constexpr double fewest = 8.0;  // pauses
  return count >= fewest && ii > 0.0 ? interval + ir / ii : interval;
}

}  // namespace

std::optional<Timeline> timeline_of_bursts(const Channel& channel) {
  if (channel.timeline.uniform()) return {};
  const Clock clock = clock_of(channel);
  if (!clock.even || !clock.gaps.empty() || clock.backward > 0 || !(clock.longest_pause * clock.rate > of_a_burst))
    return {};
  const double interval = interval_of_bursts(channel, 1.0 / clock.rate);
  double earliest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < channel.values.size(); ++i)
    earliest = std::min(earliest, channel.time(i) - static_cast<double>(i) * interval);
  return Timeline{earliest, 1.0 / interval, nullptr};
}

std::optional<std::vector<Recording>> with_clocks_of_bursts(const std::vector<Recording>& recordings) {
  std::optional<std::vector<Recording>> out;
  std::map<const void*, std::optional<Timeline>> known;  // channels of one file share their stamps
  for (std::size_t r = 0; r < recordings.size(); ++r)
    for (std::size_t c = 0; c < recordings[r].channels.size(); ++c) {
      const Channel& channel = recordings[r].channels[c];
      const auto [found, first] = known.try_emplace(channel.timeline.stamps.get());
      if (first) found->second = timeline_of_bursts(channel);
      if (!found->second) continue;
      if (!out) out = recordings;
      (*out)[r].channels[c].timeline = *found->second;
    }
  return out;
}

}  // namespace tumble
