#include "tumble/reduce/thermal/thermal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/math/regression/smoothing.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/units/error.hpp"

namespace tumble::thermal {

Slice slice(const Channel& channel, double begin, double end) {
  Slice out;
  const SampleRange range = samples_between(channel, begin, end);
  for (std::size_t k = range.begin; k < range.end; ++k) {
    out.time.push_back(channel.time(k));
    out.value.push_back(channel.values[k]);
  }
  return out;
}

void refuse_backward(const Channel& channel) {
  if (channel.timeline.uniform()) return;
  const auto& stamps = *channel.timeline.stamps;
  const auto back = std::ranges::adjacent_find(stamps, [](double a, double b) { return b <= a; });
  if (back != stamps.end())
    throw Error(Error::Kind::bad_data,
                say("channel {}: the clock does not advance at {:.6f} s (next stamp {:.6f} s); mend the stamps "
                    "before the test is reduced",
                    Name{channel.name}, *back, *std::next(back)));
}

/// Mean time between readings [s]; infinite: one reading.
double reading_spacing(const std::vector<double>& times) {
  return times.size() > 1 ? (times.back() - times.front()) / static_cast<double>(times.size() - 1)
                          : std::numeric_limits<double>::infinity();
}

namespace {

constexpr double gap_of_readings = 3.0;  ///< [readings] without which the course between two is not known

/// Linear interpolation of a smoothed sensor onto other stamps.
double between(const std::vector<double>& time, const std::vector<double>& value, double at) {
  const auto upper = std::ranges::lower_bound(time, at);
  if (upper == time.begin()) return value.front();
  if (upper == time.end()) return value.back();
  const auto k = static_cast<std::size_t>(upper - time.begin());
  const double weight = (at - time[k - 1]) / (time[k] - time[k - 1]);
  return value[k - 1] + weight * (value[k] - value[k - 1]);
}

std::vector<double> onto(const std::vector<double>& from, const std::vector<double>& value,
                         const std::vector<double>& to) {
  if (from == to) return value;
  std::vector<double> out(to.size());
  for (std::size_t k = 0; k < to.size(); ++k) out[k] = between(from, value, to[k]);
  return out;
}

/// A local quadratic within a gap of the readings extrapolates: where the gap is longer than half a window, there is no
/// temperature in it.
void blank_gaps(const Slice& readings, double half, Smoothed& smooth) {
  double before = readings.time.front();
  std::size_t last = 0;
  for (std::size_t k = 0; k < readings.time.size(); ++k) {
    if (std::isnan(readings.value[k])) continue;
    if (readings.time[k] - before > std::max(half, gap_of_readings * reading_spacing(readings.time)))
      for (std::size_t i = last + 1; i < k; ++i) smooth.value[i] = smooth.slope[i] = smooth.curvature[i] = std::nan("");
    before = readings.time[k];
    last = k;
  }
}

}  // namespace

Thermal thermal_of(const Sensors& sensors, double begin, double end, const ThermalReading& reading) {
  const double half = 0.5 * reading.smoothing;
  const Slice top = slice(*sensors.top, begin, end);
  if (top.time.empty())
    throw Error(Error::Kind::bad_data, say("channel {}: no sample in the run", Name{sensors.top->name}));
  Smoothed smooth = local_quadratic(top.time, top.value, half);
  blank_gaps(top, half, smooth);
  Smoothed other = smooth;
  if (sensors.side != nullptr) {
    const Slice side = slice(*sensors.side, begin, end);
    if (side.time.empty())
      throw Error(Error::Kind::bad_data, say("channel {}: no sample in the run", Name{sensors.side->name}));
    Smoothed s = local_quadratic(side.time, side.value, half);
    blank_gaps(side, half, s);
    other = {onto(side.time, s.value, top.time), onto(side.time, s.slope, top.time),
             onto(side.time, s.curvature, top.time)};
  }
  Thermal out{top.time, std::vector<Felt>(top.time.size()), 0.0};
  const double from = std::isfinite(begin) ? begin : top.time.front();
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t k = 0; k < out.time.size(); ++k) {
    Felt& felt = out.felt[k];
    felt.temperature_rate =
        0.5 * (smooth.slope[k] + other.slope[k] + reading.lag * (smooth.curvature[k] + other.curvature[k]));
    felt.temperature = 0.5 * (smooth.value[k] + other.value[k] + reading.lag * (smooth.slope[k] + other.slope[k]));
    felt.temperature_gradient = smooth.value[k] - other.value[k] + reading.lag * (smooth.slope[k] - other.slope[k]);
    felt.since_power_on = out.time[k] - from;
    if (felt.since_power_on < reading.start_window - stamp_slack(out.time[k], 0.0) && !std::isnan(felt.temperature)) {
      sum += felt.temperature;
      ++count;
    }
  }
  if (count == 0)
    throw Error(Error::Kind::bad_data, say("channel {}: no temperature in the start window", Name{sensors.top->name}));
  out.start_temperature = sum / static_cast<double>(count);
  for (auto& felt : out.felt) felt.start_temperature = out.start_temperature;
  return out;
}

Felt felt_at(const Thermal& thermal, double time) {
  const auto upper = std::ranges::lower_bound(thermal.time, time);
  if (upper == thermal.time.end()) return thermal.felt.back();
  const auto k = static_cast<std::size_t>(upper - thermal.time.begin());
  if (k == 0 || *upper == time) return thermal.felt[k];
  const Felt &a = thermal.felt[k - 1], &b = thermal.felt[k];
  const double w = (time - thermal.time[k - 1]) / (thermal.time[k] - thermal.time[k - 1]);
  Felt felt = a;
  felt.temperature += w * (b.temperature - a.temperature);
  felt.temperature_gradient += w * (b.temperature_gradient - a.temperature_gradient);
  felt.temperature_rate += w * (b.temperature_rate - a.temperature_rate);
  felt.since_power_on += w * (b.since_power_on - a.since_power_on);
  return felt;
}

}  // namespace tumble::thermal
