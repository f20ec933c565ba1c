#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/marks.hpp"
#include "tumble/core/say.hpp"
#include "tumble/methods/rlg_north_finder/faults.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/reduce/stretches.hpp"

namespace tumble::rlg_north_finder {
namespace {

using Severity = Finding::Severity;

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
    const double step = 1.0 / mean_rate(channel);
    for (std::size_t m = 0; m < recording.marks.size(); ++m) {
      const Mark& mark = recording.marks[m];
      const auto found =
          std::find_if(segments.begin() + static_cast<std::ptrdiff_t>(next), segments.end(),
                       [&](const auto& segment) { return segment.label == mark.label && segment.run == mark.run; });
      if (found == segments.end()) continue;
      next = static_cast<std::size_t>(found - segments.begin()) + 1;
      if (!found->steady) continue;
      Counts stay{mark.label, found->predicted * found->duration, step, {}};
      const auto size = static_cast<std::size_t>(std::llround(found->duration / step));
      // what was used lies at the end of the segment
      const std::size_t end = samples_between(channel, mark.begin, end_of_mark(recording, m) - 1e-6 * step).end;
      for (std::size_t i = end - std::min(size, end); i < end; ++i)
        if (!std::isnan(channel.values[i])) stay.values.push_back(channel.values[i] * step);
      if (stay.values.size() > 1) stays.push_back(std::move(stay));
    }
  }
  return stays;
}

/// Counts that do not move where the Earth's rate demands pulses.
void lock_in(const std::vector<Counts>& stays, Findings& findings) {
  constexpr double enough = 20.0;  // pulses
  std::vector<std::string> labels;
  for (const auto& stay : stays) {
    const bool still = std::ranges::all_of(stay.values, [](double v) { return v == 0.0; });
    if (still && std::abs(stay.expected) > enough) labels.push_back("'" + stay.label + "'");
  }
  std::size_t silent = 0;
  for (const auto& stay : stays) silent += std::ranges::all_of(stay.values, [](double v) { return v == 0.0; }) ? 1 : 0;
  if (!labels.empty() || (silent > 1 && 2 * silent >= stays.size()))
    findings.push_back(
        {Severity::error,
         fmt::format("the gyro counts nothing in {}, where the Earth's rate demands pulses: it is locked "
                     "in; switch on the dither, or see that it is random enough (rlg_lock_in)",
                     labels.empty() ? fmt::format("{} of {} stays", silent, stays.size())
                                    : fmt::format("{}", fmt::join(labels, ", "))),
         ""});
}

/// Each reading of the counter off by a part of its own makes neighbouring counts unlike: half the variance of the
/// counts is then minus their covariance.
void cut_dither(const std::vector<Counts>& stays, double scale, Findings& findings) {
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
  if (count < 30.0) return;
  const double reading = -product / count;  // variance of one reading [pulse^2]
  if (reading < 2.0 * pulses::reading_variance + 6.0 * square / count / std::sqrt(count)) return;
  const double amplitude = std::sqrt(2.0 * reading) / std::abs(scale);
  findings.push_back(
      {Severity::warning,
       fmt::format("within the stays the angle swings by some {}, as the dither does: a stay that does not hold whole "
                   "periods of it is off by up to {} over {}; strip the dither, count from zero crossing to zero "
                   "crossing, or stay longer",
                   say_difference(amplitude, Unit::parse("arcsec")),
                   say_difference(2.0 * amplitude / shortest, Unit::parse("deg/h")), say_seconds(shortest)),
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

/// The second half of a stay against the first, beside what the other stays do.
void not_at_rest(const std::vector<Counts>& stays, Which output, Findings& findings) {
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
  for (std::size_t s = 0; s < stays.size(); ++s)
    if (off[s] > 8.0 * usual) labels.push_back("'" + stays[s].label + "'");
  if (!labels.empty())
    findings.push_back({Severity::error,
                        fmt::format("the table did not come to rest in {}: the counts of the second half of the stay "
                                    "are not those of the first; let it settle longer (settling), or repeat these",
                                    fmt::join(labels, ", ")),
                        role_of(output)});
}

}  // namespace

Findings count_faults(const Evidence& evidence, const Summaries& segments, const Estimate& estimate) {
  Findings findings;
  for (const Which output : {gyro, accelerometer_x, accelerometer_y}) {
    const auto stays = stays_of(evidence, segments[output], output);
    if (output == gyro) {
      lock_in(stays, findings);
      cut_dither(stays, estimate.parameters[0].value, findings);
    }
    not_at_rest(stays, output, findings);
  }
  return findings;
}

}  // namespace tumble::rlg_north_finder
