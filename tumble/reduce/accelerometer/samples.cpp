#include "tumble/reduce/accelerometer/samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tumble/core/marks.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/reduce/accelerometer/faults.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::accelerometer {
namespace {

using linear::Solution;

constexpr double most_of_span = 0.95;  ///< [1] of the range of the segments, by which a sample jumps that overflows

constexpr double shows_slope = 1e-6;            ///< [1] of the squares: level positions alone show no slope
constexpr double fewest_of_line = 3.0;          ///< positions
constexpr int most_bits = 32, fewest_bits = 7;  ///< of a register of counts; half the modulus fits as well
/// Modulus against the greatest count and the greatest distance from the line, and [1] of that distance, within which
/// all come back after whole turns.
constexpr double of_most_count = 0.9, of_most_distance = 1.2, back_within = 0.02;
/// Spikes by one bit: [counts] at least, [usual distances] about a power of two, and [1] of the distance below which
/// that is narrow: a seventh of all distances lie so near to a power of two.
constexpr double least_spike = 100.0, near_power = 10.0, narrow = 0.05;
constexpr double level_share = 0.1;  ///< [1] of the greatest specific force, below which a position is level: 6 deg
constexpr std::size_t fewest_of_halves = 8;  ///< samples
/// [sd] and [1] of the output, between two halves.
constexpr double halves_differ_sd = 8.0, halves_differ_share = 1e-4;

/// The samples of one segment that were used [s, recording's clock].
struct Used {
  std::string label;
  double begin = 0.0, end = 0.0;
};

std::vector<Used> used_of(const Recording& recording, const Channel& channel, const Solution& solution) {
  std::vector<Used> out;
  const double last = channel.time(channel.values.size() - 1) + 1.0 / std::max(1e-9, mean_rate(channel));
  for (std::size_t m = 0; m < recording.marks.size(); ++m) {
    const auto& mark = recording.marks[m];
    const double end = std::min(end_of_mark(recording, m), last);
    double length = 0.0;
    for (const auto& segment : solution.segments)
      if (segment.label == mark.label && (length == 0.0 || segment.duration < length)) length = segment.duration;
    if (length > 0.0) out.push_back({mark.label, end - length, end});
  }
  return out;
}

std::vector<double> values_in(const Channel& channel, double begin, double end) {
  std::vector<double> values;
  const SampleRange range = samples_between(channel, begin, end);
  for (std::size_t i = range.begin; i < range.end; ++i)
    if (std::isfinite(channel.values[i])) values.push_back(channel.values[i]);
  return values;
}

/// Power of two by which the counts of some segments must be raised to lie on the line of those near zero; 0: none.
struct Overflow {
  double modulus = 0.0;
  std::vector<std::string> labels;
};

Overflow overflow_of(const Normalised& fit) {
  const auto& segments = fit.solution.segments;
  const std::size_t n = segments.size();
  std::vector<double> a, count;
  for (const auto& s : segments) {
    a.push_back(s.felt.specific_force.x);
    count.push_back(s.measured / fit.problem.scale);
  }
  std::vector<double> sizes;
  for (const double force : a) sizes.push_back(std::abs(force));
  std::ranges::sort(sizes);
  // the line through the half of the positions that feel least
  double sa = 0, sn = 0, saa = 0, san = 0, used = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (std::abs(a[i]) > sizes[(n - 1) / 2] * (1.0 + rounding_share)) continue;
    sa += a[i], sn += count[i], saa += a[i] * a[i], san += a[i] * count[i], used += 1.0;
  }
  const double spread = saa - sa * sa / used;
  if (used < fewest_of_line || !(spread > shows_slope * (saa + sizes.back() * sizes.back())))
    return {};  // level positions show no slope
  const double slope = (san - sa * sn / used) / spread, zero = (sn - slope * sa) / used;
  const auto off = [&](std::size_t i) { return zero + slope * a[i] - count[i]; };
  double worst = 0.0, most = 0.0;
  for (std::size_t i = 0; i < n; ++i)
    worst = std::max(worst, std::abs(off(i))), most = std::max(most, std::abs(count[i]));
  for (int k = most_bits; k >= fewest_bits; --k) {  // half the modulus fits as well
    const double modulus = std::ldexp(1.0, k);
    if (modulus < of_most_count * most || modulus > of_most_distance * worst) continue;
    Overflow out{modulus, {}};
    double residual = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double turns = std::round(off(i) / modulus);
      if (turns != 0.0) out.labels.push_back(segments[i].label);
      residual = std::max(residual, std::abs(off(i) - turns * modulus));
    }
    if (!out.labels.empty() && residual < back_within * worst) return out;
  }
  return {};
}

/// From the least to the greatest count. A counter of so many bits cannot show more than its modulus.
double span_of(const Channel& channel) {
  double low = 1e300, high = -1e300;
  for (const double v : channel.values)
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  return std::max(0.0, high - low);
}

/// Samples of one segment that are off its median by a power of two, `least` or more.
std::size_t overflown_samples(const Channel& channel, double begin, double end, double least, double& modulus) {
  const auto values = values_in(channel, begin, end);
  if (values.size() < 4) return 0;
  auto sorted = values;
  std::ranges::sort(sorted);
  const double median = sorted[sorted.size() / 2];
  for (auto& v : sorted) v = std::abs(v - median);
  std::ranges::sort(sorted);
  const double usual = std::max(1.0, sorted[sorted.size() / 2]);
  std::map<int, std::size_t> by_power;
  for (const double v : values) {
    const double off = std::abs(v - median);
    if (off < std::max(least_spike, least)) continue;
    const int k = static_cast<int>(std::lround(std::log2(off)));
    if (std::abs(off - std::ldexp(1.0, k)) < near_power * usual && near_power * usual < narrow * off) ++by_power[k];
  }
  if (by_power.empty()) return 0;
  const auto most = std::ranges::max_element(by_power, {}, [](const auto& power) { return power.second; });
  modulus = std::ldexp(1.0, most->first);
  return most->second;
}

/// Overflows within segments of one recording, in the samples that were used.
void find_overflown_samples(const Evidence& evidence, const Recording& recording, const Solution& solution,
                            Problems& problems) {
  const Channel& channel = require_channel(evidence, recording, "accelerometer");
  const double least = most_of_span * span_of(channel);
  for (const auto& used : used_of(recording, channel, solution)) {
    double modulus = 0.0;
    const auto bad = overflown_samples(channel, used.begin, used.end, least, modulus);
    if (bad > 0)
      problems.push_back(
          say("segment '{}': {} off the others by {:.0f}: the counter overflowed there; "
              "read it more often, or add {:.0f} to these counts",
              used.label, said_count(bad, "count"), modulus, modulus));
  }
}

struct Half {
  double mean = 0.0, variance = 0.0;  ///< of the mean
};

Half half_of(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  Half half;
  const auto n = static_cast<double>(end - begin);
  for (std::size_t i = begin; i < end; ++i) half.mean += values[i] / n;
  for (std::size_t i = begin; i < end; ++i)
    half.variance += (values[i] - half.mean) * (values[i] - half.mean) / (n * (n - 1.0));
  return half;
}

/// Segments of one value, where all others take so many that noise alone cannot keep to one.
Findings about_one_value(const Evidence& evidence, const Normalised& fit) {
  constexpr std::size_t fewest_samples = 20, values_of_noise = 5;
  std::vector<std::string> labels;
  std::string worst;
  double most = 0.0;
  std::size_t others = 0, fewest_values = values_of_noise;
  for (const auto& recording : evidence.recordings) {
    const Channel& channel = require_channel(evidence, recording, "accelerometer");
    for (const auto& used : used_of(recording, channel, fit.solution)) {
      const auto values = values_in(channel, used.begin, used.end);
      const std::set<double> different(values.begin(), values.end());
      if (values.size() < fewest_samples) continue;
      if (different.size() > 1) {
        ++others;
        fewest_values = std::min(fewest_values, different.size());
        continue;
      }
      const double output = fit.problem.scale * values.front();
      if (labels.empty() || std::abs(output) > std::abs(most)) worst = used.label, most = output;
      labels.push_back(used.label);
    }
  }
  if (labels.empty() || others < 2 || fewest_values < values_of_noise) return {};
  return {{Finding::Severity::error,
           "one_value_in_segment",
           {{"segments", all_quoted(labels)}, {"output", most, "g"}},
           "",
           {labels.size(), labels.front(), worst}}};
}

/// The greatest and the least output, where they are equal and opposite at equal and opposite specific forces, although
/// the level positions show an offset that should move both. An instrument would need K_2 = -K_0/g^2 to do that.
Findings about_opposite_ends(const Normalised& fit) {
  constexpr double least_offset = 1e-3, alike = 0.02;  // of the output at 1 g, and of the offset
  const auto& segments = fit.solution.segments;
  const auto [low, high] = std::ranges::minmax_element(segments, {}, &linear::SegmentSummary::measured);
  const double slope = (high->measured - low->measured) / (high->felt.specific_force.x - low->felt.specific_force.x);
  const double most_force = std::abs(high->felt.specific_force.x);
  double offset = 0.0, count = 0.0;
  Vector3 across;  // of the level positions together: a misalignment must not pass for an offset
  for (const auto& s : segments) {
    const Vector3& force = s.felt.specific_force;
    if (std::abs(force.x) > level_share * most_force) continue;
    offset += s.measured - slope * force.x, count += 1.0;
    across = across + force;
  }
  if (norm(across) > level_share * most_force * count) return {};
  offset /= count;
  const double forces = slope * (high->felt.specific_force.x + low->felt.specific_force.x);
  const double most = 2.0 * alike * std::abs(offset);
  if (!(count > 0.0 && std::abs(offset) > least_offset * high->measured && std::abs(forces) < most &&
        std::abs(high->measured + low->measured) < most))
    return {};
  return {{Finding::Severity::error,
           "ends_equal_and_opposite",
           {{"output", high->measured, "g"}, {"offset", offset, "g"}},
           "scale_factor"}};
}

}  // namespace

Findings about_limits(const Evidence& evidence, const Normalised& fit) {
  if (fit.output.pulses) return {};  // a quiet unit counts alike
  Findings findings = about_one_value(evidence, fit);
  return findings.empty() ? about_opposite_ends(fit) : findings;
}

Problems overflows_of(const Evidence& evidence, const Normalised& fit) {
  Problems problems;
  for (const auto& recording : evidence.recordings) find_overflown_samples(evidence, recording, fit.solution, problems);
  if (!problems.empty()) return problems;
  const auto overflow = overflow_of(fit);
  if (overflow.modulus > 0.0)
    problems.push_back(
        say("the counts of {} lie off those of the other positions by {:.0f}, a power of two: the counter overflowed; "
            "read it more often, or add {:.0f} (subtract it where the input axis is down)",
            Name{quoted(overflow.labels)}, overflow.modulus, overflow.modulus));
  return problems;
}

Findings about_unsettled(const Evidence& evidence, const Normalised& fit) {
  std::vector<std::string> labels;
  std::string worst;
  double most = 0.0;
  for (const auto& recording : evidence.recordings) {
    const Channel& channel = require_channel(evidence, recording, "accelerometer");
    for (const auto& used : used_of(recording, channel, fit.solution)) {
      const auto values = values_in(channel, used.begin, used.end);
      const std::size_t n = values.size();
      if (n < fewest_of_halves) continue;
      const Half first = half_of(values, 0, n / 2), second = half_of(values, n / 2, n);
      const double change = fit.problem.scale * (second.mean - first.mean);
      const double noise = std::abs(fit.problem.scale) * std::sqrt(first.variance + second.variance);
      if (std::abs(change) <=
          std::max(halves_differ_sd * noise, halves_differ_share * std::abs(fit.problem.scale * first.mean)))
        continue;
      if (labels.empty() || std::abs(change) > std::abs(most)) worst = used.label, most = change;
      labels.push_back(used.label);
    }
  }
  if (labels.empty()) return {};
  return {{Finding::Severity::warning,
           "segment_still_changes",
           {{"change", most, "g"}, {"segments", all_quoted(labels)}},
           "",
           {labels.size(), labels.front(), worst}}};
}

}  // namespace tumble::accelerometer
