#include "tumble/methods/gyro_scale_factor/screen.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/normal.hpp"
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
constexpr std::size_t few_values = 3;    ///< of most segments: an output whose steps exceed its noise
/// [sd of a sample] that the output of a segment is away from zero, and [1] of its median that the samples beside a zero
/// are: then zero is no value that the gyro gave. Chosen: noise passes from there to zero and back in 1e-9 of samples.
constexpr double far_from_zero = 20.0, least_beside = 0.5;
constexpr std::size_t most_zeros_together = 3;
/// Samples that are lost by their value: [1] of a segment that lacks none, and how many are lost beside it. The greatest that
/// is left is nearer to the median than [sd of a sample]: of 20 normal numbers it is so with p = 0.01, and it is where
/// every greater rate is lost whole.
constexpr double hardly_lost = 0.02, near_median = 1.2;
constexpr std::size_t fewest_lost = 5, fewest_left = 20;

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

/// sd of a sample of a part by the median of its distances, at least a part in 1e9 of the output.
double scatter_of(const Channel& channel, const Part& part) {
  constexpr double exact = 1e-9;
  std::vector<double> off;
  for (std::size_t i = part.begin; i < part.end; ++i) off.push_back(std::abs(channel.values[i] - part.median));
  return std::max(sd_of_median_size * median_of(std::move(off)), exact * std::abs(part.median));
}

/// Number of zeros from sample i on that stand between two values of the part far from zero; 0: they do not.
std::size_t zeros_between(const std::vector<double>& x, const Part& part, std::size_t i) {
  const auto far = [&](double value) { return value / part.median > least_beside; };
  if (i == part.begin || !far(x[i - 1])) return 0;
  std::size_t end = i;
  while (end < part.end && x[end] == 0.0) ++end;
  return end < part.end && far(x[end]) && end - i <= most_zeros_together ? end - i : 0;
}

/// Least change from one sample to the next that is none [u]: the step of a coarse output.
double least_change(const std::vector<double>& x) {
  double least = INFINITY;
  for (std::size_t i = 1; i < x.size(); ++i)
    if (const double change = std::abs(x[i] - x[i - 1]); change > 0.0) least = std::min(least, change);
  return least;
}

/// Zeros that a driver wrote where it had no sample.
void remove_zeros(const std::vector<Part>& parts, Channel& channel, Findings& findings) {
  std::size_t zeros = 0, first = 0;
  const double step = least_change(channel.values);
  for (const Part& part : parts) {
    if (!(std::abs(part.median) > far_from_zero * std::max(step, scatter_of(channel, part)))) continue;
    for (std::size_t i = part.begin; i < part.end; ++i) {
      const std::size_t here = channel.values[i] == 0.0 ? zeros_between(channel.values, part, i) : 0;
      if (here > 0 && zeros == 0) first = i;
      zeros += here;
      for (std::size_t k = 0; k < here; ++k) channel.values[i + k] = std::nan("");
    }
  }
  if (zeros == 0) return;
  const double share = static_cast<double>(zeros) / static_cast<double>(channel.values.size());
  findings.push_back({Finding::Severity::warning,
                      "zeros_not_used",
                      {{"part", share, "%"}},
                      channel.name,
                      {zeros, channel.time(first), {}}});
}

/// Whether most segments have so few different values that noise carries samples from one to the next.
bool comes_in_steps(const std::vector<Part>& parts, const Channel& channel) {
  std::ptrdiff_t in_steps = 0;
  for (const Part& part : parts) {
    std::set<double> different;
    for (std::size_t i = part.begin; i < part.end && different.size() <= few_values; ++i)
      if (!std::isnan(channel.values[i])) different.insert(channel.values[i]);
    in_steps += different.size() > 0 && different.size() <= few_values;
  }
  return 2 * in_steps > std::ssize(parts);
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
  const bool counts = channel.kind == QuantityKind::count, coarse = !counts && comes_in_steps(parts, channel);
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
      partly = partly || (s < whole_share && !counts && !coarse);
    }
    if (at_extreme.empty()) continue;
    const auto [least, most] =
        std::ranges::minmax(at_extreme, {}, [](const Part* part) { return std::abs(part->rate); });
    // Without noise every segment is one value: then only two rates with the same one are clipped.
    const auto noisy = std::ranges::count_if(
        parts, [&](const Part& part) { return share(channel, part, part.median) < one_value_share; });
    partly = partly || (!coarse && 2 * noisy > std::ssize(parts));
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

/// The segments of one commanded rate.
struct AtRate {
  std::size_t samples = 0, lost = 0;
  double scatter = 0.0;             ///< [u] greatest of the segments
  std::vector<double> values = {};  ///< that are left
  bool gone() const { return values.empty() && lost > 0; }
};

/// By what the output is due to be, the greatest first. Given: sense, 1 or -1 where the greatest rate comes last.
std::vector<AtRate> by_rate(const std::vector<Part>& parts, const Channel& channel, double sense) {
  std::map<double, AtRate> rates;
  for (const Part& part : parts) {
    if (std::isnan(part.rate)) continue;
    AtRate& at = rates[-sense * part.rate];
    const double scatter = std::isnan(part.median) ? 0.0 : scatter_of(channel, part);
    at.scatter = std::max(at.scatter, scatter);
    for (std::size_t i = part.begin; i < part.end; ++i) {
      ++at.samples;
      if (std::isnan(channel.values[i]))
        ++at.lost;
      else
        at.values.push_back(channel.values[i]);
    }
  }
  std::vector<AtRate> out;
  for (auto& [rate, at] : rates) out.push_back(std::move(at));
  return out;
}

/// 1 where the output grows with the rate, -1 where it falls; 0: not known.
double sense_of(const std::vector<Part>& parts) {
  double product = 0.0, mean = 0.0, count = 0.0;
  for (const Part& part : parts)
    if (!std::isnan(part.rate) && !std::isnan(part.median)) mean += part.median, ++count;
  for (const Part& part : parts)
    if (!std::isnan(part.rate) && !std::isnan(part.median)) product += part.rate * (part.median - mean / count);
  return product > 0.0 ? 1.0 : product < 0.0 ? -1.0 : 0.0;
}

/// The value beyond which samples are lost at one end: the greatest rates lack all, the one below lacks those of its noise
/// that are on this side, and no other lacks any. Given: sign, 1 for the greatest. Returned: none, where that is not so.
std::optional<double> end_by_value(const std::vector<AtRate>& rates, double sign) {
  std::size_t k = 0, gone = 0;
  for (; k < rates.size() && rates[k].gone(); ++k) gone += rates[k].lost;
  if (gone == 0 || k + 1 >= rates.size()) return {};
  const AtRate& cut = rates[k];
  if (cut.lost < fewest_lost || cut.values.size() < fewest_left) return {};
  std::vector<double> usual;
  for (std::size_t other = k + 1; other < rates.size(); ++other) {
    if (static_cast<double>(rates[other].lost) > hardly_lost * static_cast<double>(rates[other].samples)) return {};
    usual.push_back(rates[other].scatter);
  }
  double end = -INFINITY;
  for (const double value : cut.values) end = std::max(end, sign * value);
  if (end - sign * median(cut.values) > near_median * median(usual)) return {};
  return sign * end;
}

void report_lost(const std::vector<Part>& parts, const Channel& channel, Findings& findings) {
  const double sense = sense_of(parts);
  std::size_t lost = 0, first = channel.values.size();
  for (std::size_t i = 0; i < channel.values.size(); ++i)
    if (std::isnan(channel.values[i])) first = std::min(first, i), ++lost;
  if (sense == 0.0 || lost == 0) return;
  const double part = static_cast<double>(lost) / static_cast<double>(channel.values.size());
  for (const double sign : {1.0, -1.0})
    if (const auto end = end_by_value(by_rate(parts, channel, sign * sense), sign))
      findings.push_back({Finding::Severity::error,
                          sign > 0.0 ? "largest_values_missing" : "smallest_values_missing",
                          {{"limit", *end, channel.unit}, {"part", part, "%"}},
                          channel.name,
                          {lost, channel.time(first)}});
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
      report_lost(parts_of(marks[r], channel), channel, findings);
      remove_zeros(parts_of(marks[r], channel), channel, findings);
      remove_jumps(parts_of(marks[r], channel), channel, findings);
      remove_clipped(parts_of(marks[r], channel), channel, findings);
    }
    if (const double factor = per_second_of(channel); factor != 1.0)
      for (double& v : channel.values) v *= factor;
  }
  return out;
}

}  // namespace tumble::gyro_scale_factor
