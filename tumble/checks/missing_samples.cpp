#include <cmath>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/each_channel.hpp"
#include "tumble/checks/support/segments.hpp"
#include "tumble/core/channel.hpp"
#include "tumble/math/extremes.hpp"

namespace tumble::checks::missing_samples {

namespace {

using namespace support;

bool complete(const std::vector<double>& values) {
  const Extremes extremes = extremes_of(values);
  return extremes.present == values.size() && std::isfinite(extremes.lowest) && std::isfinite(extremes.highest);
}

/// A sample that reaches out of all segments.
bool is_between(const Recording& recording, const Channel& channel, std::size_t i) {
  const double begin = channel.time(i), end = begin + 1.0 / mean_rate(channel);
  return is_between_segments(recording, begin, begin) || is_between_segments(recording, end, end);
}

Findings look_at(const Recording& recording, const Channel& channel) {
  if (complete(channel.values)) return {};
  const std::size_t size = channel.values.size();
  std::size_t missing = 0, run = 0, longest = 0, longest_begin = 0;
  for (std::size_t i = 0; i < size; ++i) {
    run = std::isfinite(channel.values[i]) || is_between(recording, channel, i) ? 0 : run + 1;
    missing += run > 0;
    if (run > longest) longest = run, longest_begin = i + 1 - run;
  }
  if (missing == 0 && size > 0) return {};
  if (missing == size)
    return {{Finding::Severity::error, size == 0 ? "no_samples" : "all_samples_missing", {}, channel.name}};
  const double part = static_cast<double>(missing) / static_cast<double>(size);
  return {{2 * missing > size ? Finding::Severity::error : Finding::Severity::warning,
           "missing_samples",
           {{"samples", size}, {"part", part, "%"}, {"longest", longest}},
           channel.name,
           {missing, {}, channel.time(longest_begin)}}};
}

Findings run(const Recording& recording, const Plan*) {
  return findings_of_each(recording, [&](const Channel& channel) { return look_at(recording, channel); });
}

}  // namespace

extern const Check missing_samples{"missing_samples", "blank, NaN or infinite samples", run};

}  // namespace tumble::checks::missing_samples
