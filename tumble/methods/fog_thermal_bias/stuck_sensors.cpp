#include "tumble/methods/fog_thermal_bias/stuck_sensors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "tumble/methods/fog_thermal_bias/data.hpp"
#include "tumble/reduce/stretches.hpp"

namespace tumble::fog_thermal_bias {
namespace {

constexpr double same_reading = 1e-9;    ///< [K] readings that differ by less are equal: rounding of the conversion
constexpr double fewest_readings = 8.0;  ///< before the end, whose scatter about a line is compared

constexpr double shortest = 300.0, before = 60.0;  ///< [s]
constexpr double least_movement = 1.0;             ///< [K]
constexpr double steps = 8.0;                      ///< of the readings
constexpr double of_other = 3.0;                   ///< times as much: the two places of a case differ by some kelvins

/// Readings of a channel in a run.
struct Readings {
  std::vector<double> time, value;
  double step = 0.0;  ///< smallest change between two readings [K]
};

Readings readings_of(const Channel& channel, const Run& run) {
  Readings out;
  const SampleRange range = samples_between(channel, run.begin, run.end);
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t k = range.begin; k < range.end; ++k) {
    if (std::isnan(channel.values[k])) continue;
    // Readings that differ by rounding alone are equal.
    if (!out.value.empty())
      if (const double change = std::abs(channel.values[k] - out.value.back()); change > same_reading)
        step = std::min(step, change);
    out.time.push_back(channel.time(k));
    out.value.push_back(channel.values[k]);
  }
  out.step = std::isfinite(step) ? step : 0.0;
  return out;
}

double least_change(const Readings& readings) { return std::max(least_movement, steps * readings.step); }

/// Greatest less smallest reading between two times.
double movement(const Readings& readings, double begin, double end) {
  const auto first = std::ranges::lower_bound(readings.time, begin) - readings.time.begin();
  const auto last = std::ranges::upper_bound(readings.time, end) - readings.time.begin();
  if (last - first < 2) return 0.0;
  const auto [low, high] = std::minmax_element(readings.value.begin() + first, readings.value.begin() + last);
  return *high - *low;
}

/// Whether readings change evenly up to `end` and then stop: their scatter about a line shows that they had noise.
bool stops_at_once(const Readings& readings, std::size_t end) {
  std::size_t first = end;
  while (first > 0 && readings.time[end] - readings.time[first - 1] <= before) --first;
  const auto n = static_cast<double>(end - first);
  if (n < fewest_readings || std::abs(readings.value[end] - readings.value[first]) < least_change(readings))
    return false;
  double t = 0.0, y = 0.0, tt = 0.0, ty = 0.0, yy = 0.0;
  for (std::size_t k = first; k < end; ++k) {
    t += (readings.time[k] - readings.time[first]) / n;
    y += (readings.value[k] - readings.value[first]) / n;
  }
  for (std::size_t k = first; k < end; ++k) {
    const double dt = readings.time[k] - readings.time[first] - t, dy = readings.value[k] - readings.value[first] - y;
    tt += dt * dt;
    ty += dt * dy;
    yy += dy * dy;
  }
  return std::sqrt(std::max(0.0, yy - ty * ty / tt) / (n - 2.0)) > 0.5 * readings.step;
}

/// Where a reading stays for long although the temperature moves.
struct Stretch {
  double begin = 0.0, length = 0.0;  ///< [s]
};

std::vector<Stretch> stuck_in(const Readings& own, const Readings* other) {
  std::vector<Stretch> out;
  for (std::size_t first = 0, last = 0; first < own.value.size(); first = last) {
    while (last < own.value.size() && std::abs(own.value[last] - own.value[first]) <= same_reading) ++last;
    const double begin = own.time[first], end = own.time[last - 1];
    if (end - begin < shortest) continue;
    const bool jumps = last < own.value.size() && std::abs(own.value[last] - own.value[first]) >= least_change(own) &&
                       own.time[last] - end < before;
    const bool moves = other != nullptr && movement(*other, begin, end) >= of_other * least_change(*other);
    if (moves || jumps || (other == nullptr && stops_at_once(own, first))) out.push_back({begin, end - begin});
  }
  return out;
}

}  // namespace

Findings stuck_sensors(const Evidence& evidence) {
  struct Case {
    Occurrences occurrences{0, {}, {}};
    double longest = 0.0;
  };
  std::map<std::string, Case> cases;
  for (const Run& run : runs_of(evidence.recordings)) {
    const Recording& recording = evidence.recordings[run.recording];
    const Channel* top = channel_for(evidence, recording, "temperature_top");
    const Channel* side = channel_for(evidence, recording, "temperature_side");
    if (top == nullptr || side == nullptr) top = channel_for(evidence, recording, "temperature"), side = nullptr;
    if (top == nullptr) continue;
    const Readings of_top = readings_of(*top, run), of_side = side ? readings_of(*side, run) : Readings{};
    for (const Channel* channel : {top, side}) {
      if (channel == nullptr) continue;
      const auto stretches = channel == top ? stuck_in(of_top, side ? &of_side : nullptr) : stuck_in(of_side, &of_top);
      for (const Stretch& stretch : stretches) {
        Case& own = cases[channel->name];
        const Place place(fmt::format("run {}", run.number), stretch.begin);
        if (own.occurrences.count++ == 0) own.occurrences.first = place;
        if (stretch.length > own.longest) own.longest = stretch.length, own.occurrences.worst = place;
      }
    }
  }
  Findings findings;
  for (const auto& [channel, own] : cases)
    findings.push_back({Finding::Severity::error,
                        "temperature_sensor_stuck",
                        {{"length", own.longest, "s"}},
                        channel,
                        own.occurrences});
  return findings;
}

}  // namespace tumble::fog_thermal_bias
