#include "tumble/methods/gyro_scale_factor/screen.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/math/median.hpp"
#include "tumble/reduce/stretches.hpp"

namespace tumble::gyro_scale_factor {
namespace {

/// [range of the medians] beyond the medians of all segments, where a value is a jump.
constexpr double jump_beyond = 3.0;
/// [1] of the samples of a segment at one extreme: from the first on the segment may be clipped; below the second it is
/// in part, so that noise carries it there.
constexpr double at_extreme_share = 0.2, whole_share = 0.999;
constexpr double one_value_share = 0.5;  ///< [1] of the samples at the median: a segment without noise
constexpr double two_rates = 1.01;       ///< ratio of two rates with one output, which is therefore clipped

/// Part of a channel between two marks.
struct Part {
  std::string label;
  double rate = 0.0;  ///< commanded [rad/s]; NaN: the schedule has no such segment
  std::size_t begin = 0, end = 0;
  double median = 0.0;
};

double median_of(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  return median(std::move(values));
}

std::vector<Part> parts_of(const std::vector<MarkedSegment>& marks, const Channel& channel) {
  std::vector<Part> parts;
  for (const auto& marked : marks) {
    const SampleRange range = samples_between(channel, marked.begin, marked.end);
    parts.push_back({marked.label, marked.planned ? commanded_rate(*marked.planned) : NAN, range.begin, range.end,
                     median_of({channel.values.begin() + static_cast<std::ptrdiff_t>(range.begin),
                                channel.values.begin() + static_cast<std::ptrdiff_t>(range.end)})});
  }
  return parts;
}

void remove_jumps(const std::vector<Part>& parts, Channel& channel, Findings& findings) {
  double low = INFINITY, high = -INFINITY;
  for (const Part& part : parts)
    if (!std::isnan(part.median)) low = std::min(low, part.median), high = std::max(high, part.median);
  if (!(high > low)) return;
  std::size_t jumps = 0, first = 0;
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    double& v = channel.values[i];
    if (std::isnan(v) || (v > low - jump_beyond * (high - low) && v < high + jump_beyond * (high - low))) continue;
    if (jumps++ == 0) first = i;
    v = std::nan("");
  }
  if (jumps > 0)
    findings.push_back({Finding::Severity::warning, "jumps", {}, channel.name, {jumps, channel.time(first), {}}});
}

/// How much of a part is exactly `value`.
double share(const Channel& channel, const Part& part, double value) {
  std::size_t equal = 0, all = 0;
  for (std::size_t i = part.begin; i < part.end; ++i) {
    all += !std::isnan(channel.values[i]);
    equal += channel.values[i] == value;
  }
  return all == 0 ? 0.0 : static_cast<double>(equal) / static_cast<double>(all);
}

void remove_clipped(const std::vector<Part>& parts, Channel& channel, Findings& findings) {
  for (const double sign : {1.0, -1.0}) {
    double extreme = -INFINITY;
    for (const double v : channel.values)
      if (!std::isnan(v)) extreme = std::max(extreme, sign * v);
    extreme *= sign;
    std::vector<const Part*> at_extreme;
    bool partly = false;
    for (const Part& part : parts) {
      const double s = share(channel, part, extreme);
      if (s < at_extreme_share || std::isnan(part.rate)) continue;
      at_extreme.push_back(&part);
      partly = partly || (s < whole_share && channel.kind != QuantityKind::count);
    }
    if (at_extreme.empty()) continue;
    const auto [least, most] =
        std::ranges::minmax(at_extreme, {}, [](const Part* part) { return std::abs(part->rate); });
    // Without noise every segment is one value: then only two rates with the same one are clipped.
    const auto noisy = std::ranges::count_if(
        parts, [&](const Part& part) { return share(channel, part, part.median) < one_value_share; });
    partly = partly || 2 * noisy > std::ssize(parts);
    if (!partly && std::abs(most->rate) <= two_rates * std::abs(least->rate)) continue;
    for (const Part* part : at_extreme)
      findings.push_back({Finding::Severity::error,
                          "segment_clipped",
                          {{"share", share(channel, *part, extreme), "%"}, {"limit", extreme, channel.unit}},
                          part->label});
    for (const Part* part : at_extreme)
      std::fill(channel.values.begin() + static_cast<std::ptrdiff_t>(part->begin),
                channel.values.begin() + static_cast<std::ptrdiff_t>(part->end), std::nan(""));
  }
}

}  // namespace

double commanded_rate(const Segment& segment) {
  for (const auto& [axis, motion] : segment.axes)
    if (motion.kind == Motion::Kind::rate) return motion.value;
  return 0.0;
}

double per_second_of(const Channel& channel) {
  const bool increments = channel.kind == QuantityKind::angle || channel.kind == QuantityKind::count;
  return increments ? sampling_rate(channel) : 1.0;
}

Evidence screened(const Evidence& evidence, const std::string& role, Findings& findings) {
  Evidence out = evidence;
  const auto marks = marked_segments(evidence);
  for (std::size_t r = 0; r < out.recordings.size(); ++r) {
    Recording& recording = out.recordings[r];
    const Channel* output = channel_for(out, recording, role);
    if (output == nullptr || output->values.size() < 2) continue;
    Channel& channel = recording.channels[static_cast<std::size_t>(output - recording.channels.data())];
    if (!recording.marks.empty()) {
      remove_jumps(parts_of(marks[r], channel), channel, findings);
      remove_clipped(parts_of(marks[r], channel), channel, findings);
    }
    if (const double factor = per_second_of(channel); factor != 1.0)
      for (double& v : channel.values) v *= factor;
  }
  return out;
}

}  // namespace tumble::gyro_scale_factor
