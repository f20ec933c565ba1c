#include "tumble/methods/accelerometer_four_position/counts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/core/marks.hpp"
#include "tumble/math/median.hpp"
#include "tumble/reduce/vibration/windows.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer_four_position {
namespace {

/// [usual windows] from which on a window holds two: halfway between one and two.
constexpr double longest_window = 1.5;
/// [turns of the register] by which a count is off that overflowed: one to four. More would be another scale factor.
constexpr double least_turns = 0.5, most_turns = 4.5;
/// [1] of the register, within which a count comes back after whole turns. Chosen: by accident one count in 25 does.
constexpr double back_within = 0.02;
/// [1] of the register, that the expected count must exceed: smaller ones do not reach its end.
constexpr double least_count_of_register = 0.3;
/// [1] of the expected count, within which a count of the other sign is a head that is turned over.
constexpr double turned_over_within = 0.1;
/// One window in so many must show the overflow: a head in motion has few.
constexpr std::size_t least_part_of_windows = 10;

/// [s] from each stamp to the next; the last as the median.
std::vector<double> intervals_of(const Channel& channel) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < channel.values.size(); ++i) intervals.push_back(channel.time(i) - channel.time(i - 1));
  if (!channel.values.empty()) intervals.push_back(intervals.empty() ? 0.0 : median(intervals));
  return intervals;
}

std::vector<std::pair<double, double>> segments_of(const Recording& recording, const Channel& channel) {
  std::vector<std::pair<double, double>> segments;
  const double last = channel.values.empty() ? 0.0 : channel.time(channel.values.size() - 1);
  for (std::size_t m = 0; m < recording.marks.size(); ++m)
    segments.emplace_back(recording.marks[m].begin, std::min(end_of_mark(recording, m), last));
  return segments;
}

/// Counts over their windows, which last from stamp to stamp where `own` says so.
void divide_by_windows(Channel& channel, bool own, const std::string& file, Findings& findings) {
  const auto intervals = intervals_of(channel);
  const double usual = intervals.empty() ? 0.0 : median(intervals);
  std::size_t missed = 0, together = 0;
  double before = NAN;
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    double window = usual;
    if (own && intervals[i] < longest_window * usual) window = intervals[i];
    if (intervals[i] > longest_window * usual && std::isfinite(before)) {
      const double over_interval = channel.values[i] / intervals[i], over_window = channel.values[i] / usual;
      const bool all = std::abs(over_interval - before) < std::abs(over_window - before);
      if (all) window = intervals[i];
      ++(all ? together : missed);
    }
    channel.values[i] /= window;
    if (std::isfinite(channel.values[i])) before = channel.values[i];
  }
  using enum Finding::Severity;
  const std::string where = (file.empty() ? "" : file + ": ") + channel.name;
  const FindingValue windows("windows", channel.values.size());
  if (missed > 0) findings.push_back({warning, "windows_before_gap", {windows}, where, {missed, {}, {}}});
  if (together > 0) findings.push_back({warning, "long_windows", {windows}, where, {together, {}, {}}});
}

void to_rates(const Recording& recording, Channel& channel, Findings& findings) {
  const auto output = accelerometer::output_of(channel);
  if (!output.pulses) return;
  if (channel.timeline.uniform()) {
    for (double& v : channel.values) v *= channel.timeline.rate;
  } else {
    const double slope = vibration::slope_with_interval(channel, segments_of(recording, channel));
    divide_by_windows(channel, slope > 0.5, recording.origin.file, findings);
  }
  channel.unit = Unit::parse("pulse/s");
  channel.kind = QuantityKind::other;
}

/// The n for which the means differ by 2^n pulses; 0: none. A unit that is turned over shows the expected count with
/// the other sign. Just past the end of the register an overflow does nearly so: what is nearer to the count decides.
int overflow_bits(double measured, double expected) {
  const double turned_over = std::abs(measured + expected);
  for (const int bits : {32, 31, 24, 20, 18, 16, 15, 14, 12, 10, 8}) {
    const double size = std::ldexp(1.0, bits), turns = (measured - expected) / size;
    const double off = std::abs(turns - std::round(turns)) * size;
    if (std::abs(turns) > least_turns && std::abs(turns) < most_turns && off < back_within * size &&
        std::abs(expected) > least_count_of_register * size &&
        std::abs(measured) < size)  // no register shows more than it holds
      return turned_over < turned_over_within * std::abs(expected) && turned_over <= off ? 0 : bits;
  }
  return 0;
}

}  // namespace

Evidence per_second(const Evidence& evidence, const std::string& role, Findings& findings) {
  Evidence out;
  out.plan = evidence.plan;
  out.plans = evidence.plans;
  for (const auto& recording : evidence.recordings) {
    const Channel& channel = require_channel(evidence, recording, role);
    Recording rates;
    rates.instrument = recording.instrument;
    rates.marks = recording.marks;
    rates.origin = recording.origin;
    rates.channels = {channel};
    to_rates(recording, rates.channels.front(), findings);
    out.recordings.push_back(std::move(rates));
  }
  return out;
}

void refuse_overflow(const Bench& bench) {
  if (!bench.output.pulses) return;
  Problems problems;
  for (const auto& position : bench.positions) {
    const auto& stretch = bench.evidence.test.stretches[position.stretch];
    const double window = bench.reference_scale_factor * stretch.step;  // pulses for a unit of specific force
    const double expected = window * bench.rows.segments[position.stretch].felt.specific_force.x;
    std::map<int, std::size_t> windows;  // by bits; a window in which the head moves may look like an overflow
    for (const double v : stretch.values) ++windows[overflow_bits(v * window, expected)];
    windows.erase(0);
    const auto most = std::ranges::max_element(windows, {}, [](const auto& bits) { return bits.second; });
    const int bits =
        most == windows.end() || least_part_of_windows * most->second < stretch.values.size() ? 0 : most->first;
    if (bits > 0)
      problems.push_back(
          say("segment '{}' of run {}: counts differ by 2^{} from the {:.0f} pulses per window that K_m "
              "predicts: a counter of {} bits overflowed. Count over shorter windows, or add the lost pulses",
              position.label, position.run, bits, expected, bits));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

}  // namespace tumble::accelerometer_four_position
