#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/core/marks.hpp"
#include "tumble/methods/rlg_north_finder/faults.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::rlg_north_finder {
namespace {

using Severity = Finding::Severity;

constexpr double one_pulse = 1.5;          ///< [pulse] a gyro that shows no more in a stay does not count
constexpr double fewest_counts = 30.0;     ///< readings, by whose correlation a dither is found
constexpr double dither_sd = 6.0;          ///< [sd] of the correlation of white readings: p = 2e-9
constexpr double expected_readings = 2.0;  ///< [1] of the variance of a reading by the rounding of pulses
constexpr double far_off = 8.0;            ///< [1] of the usual difference of a stay, at least of one pulse

/// The counts of one stay.
struct Counts {
  std::string label;
  double expected = 0.0;  ///< pulses in the whole stay, by the model
  double step = 1.0;      ///< [s]
  std::vector<double> values;
};

/// The samples of the stays that were used.
std::vector<Counts> stays_of(const Evidence& evidence, std::span<const linear::SegmentSummary> segments, Which output) {
  std::vector<Counts> stays;
  std::size_t next = 0;
  for (const auto& recording : evidence.recordings) {
    const Channel& channel = require_channel(evidence, recording, role_of(output));
    const double step = 1.0 / sampling_rate(channel);
    for (std::size_t m = 0; m < recording.marks.size(); ++m) {
      const Mark& mark = recording.marks[m];
      const auto segment =
          std::find_if(segments.begin() + static_cast<std::ptrdiff_t>(next), segments.end(),
                       [&](const auto& some) { return some.label == mark.label && some.run == mark.run; });
      if (segment == segments.end()) continue;
      next = static_cast<std::size_t>(segment - segments.begin()) + 1;
      if (!segment->steady) continue;
      Counts stay{mark.label, segment->predicted * segment->duration, step, {}};
      const auto size = static_cast<std::size_t>(std::llround(segment->duration / step));
      // the samples that were used lie at the end of the segment
      const double ends = end_of_mark(recording, m);
      const std::size_t end =
          samples_between(channel, mark.begin, std::isfinite(ends) ? ends - stamp_slack(ends, step) : ends).end;
      for (std::size_t i = end - std::min(size, end); i < end; ++i)
        if (!std::isnan(channel.values[i])) stay.values.push_back(channel.values[i] * step);
      if (stay.values.size() > 1) stays.push_back(std::move(stay));
    }
  }
  return stays;
}

/// "'2', '4'"
std::string listed(const std::vector<std::string>& labels) { return "'" + joined(labels, "', '") + "'"; }

/// Counts that do not move where the Earth's rate demands pulses. A locked phase beside an edge of the counter goes to
/// and fro over it by its noise: single pulses that add to none.
void find_lock_in(const std::vector<Counts>& stays, Findings& findings) {
  constexpr double enough = 20.0;  // pulses
  std::vector<std::string> silent, demanding;
  for (const auto& stay : stays) {
    const double total = std::accumulate(stay.values.begin(), stay.values.end(), 0.0);
    const double most = std::ranges::max(stay.values, {}, [](double v) { return std::abs(v); });
    if (std::abs(stay.expected) > enough && std::abs(most) < one_pulse && std::abs(total) < one_pulse)
      demanding.push_back(stay.label);
    if (most == 0.0) silent.push_back(stay.label);
  }
  if (demanding.empty() && (silent.size() < 2 || 2 * silent.size() < stays.size())) return;
  const auto& labels = demanding.empty() ? silent : demanding;
  findings.push_back({Severity::error,
                      "gyro_locked_in",
                      {{"stays", listed(labels)}},
                      "",
                      {labels.size(), labels.front(), labels.front()}});
}

/// Readings with errors of their own make neighbouring counts differ: the covariance of neighbours is then minus half
/// the variance of the counts.
void find_cut_dither(const std::vector<Counts>& stays, double scale, Findings& findings) {
  double product = 0.0, square = 0.0, count = 0.0, shortest = INFINITY;
  for (const auto& stay : stays) {
    double mean = 0.0;
    for (const double v : stay.values) mean += v / static_cast<double>(stay.values.size());
    for (std::size_t i = 1; i < stay.values.size(); ++i)
      product += (stay.values[i] - mean) * (stay.values[i - 1] - mean);
    for (const double v : stay.values) square += (v - mean) * (v - mean);
    count += static_cast<double>(stay.values.size());
    shortest = std::min(shortest, stay.step * static_cast<double>(stay.values.size()));
  }
  if (count < fewest_counts) return;
  const double reading = -product / count;  // variance of one reading [pulse^2]
  if (reading < expected_readings * pulses::reading_variance + dither_sd * square / count / std::sqrt(count)) return;
  const double amplitude = std::sqrt(2.0 * reading) / std::abs(scale);
  findings.push_back(
      {Severity::warning,
       "dither_cut_off",
       {{"amplitude", amplitude, "arcsec"}, {"shift", 2.0 * amplitude / shortest, "deg/h"}, {"stay", shortest, "s"}},
       role_of(gyro)});
}

double mean_of(const std::vector<double>& values, std::size_t from, std::size_t to) {
  double sum = 0.0;
  for (std::size_t i = from; i < to; ++i) sum += values[i];
  return sum / static_cast<double>(to - from);
}

/// Standard deviation of a count by the differences of neighbours, which a drift does not touch.
double scatter_of(const Counts& stay) {
  double squares = 0.0;
  for (std::size_t i = 1; i < stay.values.size(); ++i) squares += std::pow(stay.values[i] - stay.values[i - 1], 2);
  return std::sqrt(0.5 * squares / static_cast<double>(stay.values.size() - 1));
}

/// Stays whose second half differs from the first far more than in the other stays.
void find_unrest(const std::vector<Counts>& stays, Which output, Findings& findings) {
  std::vector<double> off, sizes;
  for (const auto& stay : stays) {
    const std::size_t half = stay.values.size() / 2;
    const double drift = mean_of(stay.values, half, 2 * half) - mean_of(stay.values, 0, half);
    const auto n = static_cast<double>(stay.values.size());
    const double sd =
        std::hypot(2.0 * scatter_of(stay) / std::sqrt(n), std::sqrt(2.0 * pulses::rounding_variance(1.0, 0.5 * n)));
    off.push_back(std::abs(drift) / sd);
  }
  sizes = off;
  if (sizes.size() < 4) return;
  std::ranges::sort(sizes);
  const double usual = std::max(1.0, sizes[sizes.size() / 2]);
  std::vector<std::string> labels;
  Occurrences often{0, {}, {}};
  double worst = 0.0;
  for (std::size_t s = 0; s < stays.size(); ++s) {
    if (!(off[s] > far_off * usual)) continue;
    labels.push_back(stays[s].label);
    if (off[s] > worst) worst = off[s], often.worst = stays[s].label;
  }
  if (labels.empty()) return;
  often.count = labels.size();
  often.first = labels.front();
  findings.push_back({Severity::error, "counts_not_at_rest", {{"stays", listed(labels)}}, role_of(output), often});
}

}  // namespace

Findings count_faults(const Evidence& evidence, const Summaries& segments, const Estimate& estimate) {
  Findings findings;
  for (const Which output : {gyro, accelerometer_x, accelerometer_y}) {
    const auto stays = stays_of(evidence, segments[output], output);
    if (output == gyro) {
      find_lock_in(stays, findings);
      find_cut_dither(stays, estimate.parameters[0].value, findings);
    }
    find_unrest(stays, output, findings);
  }
  return findings;
}

}  // namespace tumble::rlg_north_finder
