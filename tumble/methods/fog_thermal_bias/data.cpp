#include "tumble/methods/fog_thermal_bias/data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/core/sampling_rate.hpp"
#include "tumble/core/stamp_slack.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/regression/smoothing.hpp"
#include "tumble/methods/fog_thermal_bias/departures.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/units/error.hpp"

namespace tumble::fog_thermal_bias {
namespace {

/// The samples of a channel between two times, with their stamps.
struct Slice {
  std::vector<double> time, value;
};

Slice slice(const Channel& channel, double begin, double end) {
  Slice out;
  const SampleRange range = samples_between(channel, begin, end);
  for (std::size_t k = range.begin; k < range.end; ++k) {
    out.time.push_back(channel.time(k));
    out.value.push_back(channel.values[k]);
  }
  return out;
}

}  // namespace

void refuse_backward(const Channel& channel) {
  if (channel.timeline.uniform()) return;
  const auto& stamps = *channel.timeline.stamps;
  const auto back = std::ranges::adjacent_find(stamps, [](double a, double b) { return b <= a; });
  if (back != stamps.end())
    throw Error(Error::Kind::bad_data,
                say("channel {}: the clock does not advance at {:.6f} s (next stamp {:.6f} s); mend the stamps "
                    "before the test is reduced",
                    channel.name, *back, *std::next(back)));
}

namespace {

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

double mean_of(const Slice& s, double until, const std::string& what) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t k = 0; k < s.time.size() && s.time[k] < until - stamp_slack(until, 0.0); ++k) {
    if (std::isnan(s.value[k])) continue;
    sum += s.value[k];
    ++count;
  }
  if (count == 0) throw Error(Error::Kind::bad_data, say("{}: no sample in the start window", what));
  return sum / static_cast<double>(count);
}

struct Signals {
  const Channel* gyro;
  Sensors sensors;
};

Signals signals_of(const Evidence& evidence, const Recording& recording) {
  Signals role{&require_channel(evidence, recording, "gyro"), {}};
  role.sensors.top = channel_for(evidence, recording, "temperature_top");
  role.sensors.side = channel_for(evidence, recording, "temperature_side");
  if (role.sensors.top == nullptr || role.sensors.side == nullptr)
    role.sensors = {&require_channel(evidence, recording, "temperature"), nullptr};
  for (const Channel* channel : {role.gyro, role.sensors.top, role.sensors.side})
    if (channel != nullptr) refuse_backward(*channel);
  return role;
}

/// Intervals of `length` [s] counted from `begin` [s].
struct Intervals {
  double begin, length;
  std::size_t count;

  /// Number of the interval that holds a time [s].
  std::size_t of(double time) const {
    return static_cast<std::size_t>(std::max(0.0, (time - begin + stamp_slack(time, length)) / length));
  }
};

/// Sums of the output over the intervals; returns the samples in each.
std::vector<double> add_output(RunData& run, const Slice& gyro, const Intervals& intervals) {
  std::vector<double> samples(intervals.count, 0.0);
  for (std::size_t k = 0; k < gyro.time.size(); ++k) {
    const std::size_t i = intervals.of(gyro.time[k]);
    if (i >= intervals.count || std::isnan(gyro.value[k])) continue;
    run.output[i] += gyro.value[k];
    samples[i] += 1.0;
  }
  return samples;
}

/// Mean time between readings [s]; infinite: one reading.
double reading_spacing(const std::vector<double>& times) {
  return times.size() > 1 ? (times.back() - times.front()) / static_cast<double>(times.size() - 1)
                          : std::numeric_limits<double>::infinity();
}

/// Which part of the gyro's samples about each thermal reading was measured: where the gyro has a gap, its mean is that
/// of the rest of the interval, and so must be the mean of the temperatures. Empty: all were.
std::vector<double> measured_about(const Slice& gyro, const std::vector<double>& readings, double spacing) {
  std::vector<double> times;
  for (std::size_t k = 0; k < gyro.time.size(); ++k)
    if (!std::isnan(gyro.value[k])) times.push_back(gyro.time[k]);
  if (times.empty() || readings.size() < 2) return {};
  const double expected = (times.back() - times.front()) / spacing + 1.0;
  if (static_cast<double>(times.size()) > expected - 0.5) return {};
  const double half = 0.5 * std::max(spacing, reading_spacing(readings)) * (1.0 + 1e-9);
  std::vector<double> out;
  for (const double time : readings) {
    const auto first = std::ranges::lower_bound(times, time - half),
               last = std::ranges::lower_bound(times, time + half);
    out.push_back(std::min(1.0, static_cast<double>(last - first) * spacing / (2.0 * half)));
  }
  return out;
}

/// Sums of temperatures and regressors over the intervals, with weights where there are any; returns the sums of these.
std::vector<double> add_thermal(RunData& run, const Thermal& thermal, const std::vector<double>& weights,
                                const std::vector<Term>& terms, const Intervals& intervals) {
  std::vector<double> readings(intervals.count, 0.0);
  for (std::size_t k = 0; k < thermal.time.size(); ++k) {
    const std::size_t i = intervals.of(thermal.time[k]);
    const Felt& now = thermal.felt[k];
    const double weight = weights.empty() ? 1.0 : weights[k];
    if (i >= intervals.count || std::isnan(now.temperature) || std::isnan(now.temperature_gradient)) continue;
    if (weight == 0.0) continue;
    for (std::size_t t = 0; t < terms.size(); ++t) run.regressors(i, t) += weight * terms[t].regressor(now);
    run.felt[i].temperature += weight * now.temperature;
    run.felt[i].temperature_gradient += weight * now.temperature_gradient;
    run.felt[i].temperature_rate += weight * now.temperature_rate;
    readings[i] += weight;
  }
  return readings;
}

/// Means over intervals of `interval` [s] counted from power-on. `spacing` [s] of the gyro's clock: lost samples lessen
/// the share of their interval.
void average(RunData& run, const Slice& gyro, const Thermal& thermal, const std::vector<Term>& terms, double begin,
             double interval, double spacing) {
  const double last = gyro.time.empty() ? begin : gyro.time.back();
  const double full_intervals = std::floor((last + spacing - begin + stamp_slack(last, interval)) / interval);
  const Intervals intervals{begin, interval, static_cast<std::size_t>(std::max(0.0, full_intervals))};
  const std::size_t count = intervals.count;
  run.time.resize(count);
  run.share.assign(count, 0.0);
  run.output.assign(count, 0.0);
  run.felt.assign(count, Felt{{}, {}, {}, 0, 0, 0, thermal.start_temperature, 0});
  run.regressors = Matrix(count, terms.size());
  const auto samples = add_output(run, gyro, intervals),
             readings = add_thermal(run, thermal, measured_about(gyro, thermal.time, spacing), terms, intervals);
  const double full = interval / spacing;
  // Sensors that are slower than the interval have one reading in some intervals and none in others.
  const double full_readings = std::floor(interval / reading_spacing(thermal.time) + 1e-9);
  for (std::size_t k = 0; k < count; ++k) {
    run.time[k] = (static_cast<double>(k) + 0.5) * interval;
    const bool covered = readings[k] >= 0.9 * std::min(1.0, samples[k] / full) * full_readings;
    const bool usable = samples[k] >= 0.5 * full && readings[k] > 0.0 && covered;
    run.share[k] = usable ? std::min(1.0, samples[k] / full) : 0.0;
    const double per = readings[k] > 0.0 ? 1.0 / readings[k] : 0.0;
    run.output[k] = usable ? run.output[k] / samples[k] : 0.0;
    run.felt[k].temperature *= per;
    run.felt[k].temperature_gradient *= per;
    run.felt[k].temperature_rate *= per;
    for (std::size_t t = 0; t < terms.size(); ++t) run.regressors(k, t) *= usable ? per : 0.0;
  }
}

RunData data_of(const Evidence& evidence, const Run& run, const std::vector<Term>& terms, double lag, double interval,
                double spacing) {
  const Settings& settings = evidence.plan.settings;
  const Signals role = signals_of(evidence, evidence.recordings[run.recording]);
  const std::string where = fmt::format("run {}{}", run.number, run.label.empty() ? "" : " (" + run.label + ")");
  const Slice gyro = slice(*role.gyro, run.begin, run.end);
  if (gyro.time.size() < 2)
    throw Error(Error::Kind::bad_data, say("{}: fewer than two samples of {}", where, role.gyro->name));
  const double begin = std::isfinite(run.begin) ? run.begin : gyro.time.front();
  const Thermal thermal = thermal_of(role.sensors, run.begin, run.end, settings, lag);
  RunData out;
  out.number = run.number;
  out.label = run.label;
  out.recording = run.recording;
  out.file = evidence.recordings[run.recording].origin.file;
  out.start_temperature = thermal.start_temperature;
  out.start_output = mean_of(gyro, begin + settings.number("start_window"), where + ", channel " + role.gyro->name);
  if (settings.has("hold_out")) {
    const auto& held = settings.integers("hold_out");
    out.held_out = std::ranges::find(held, run.number) != held.end();
  }
  average(out, gyro, thermal, terms, begin, interval, spacing);
  if (out.time.empty())
    throw Error(Error::Kind::bad_data,
                say("{}: {:.6g} s of {} are shorter than one average of {:.6g} s; set averaging lower or use "
                    "hold_out for the run",
                    where, gyro.time.back() - gyro.time.front(), role.gyro->name, interval));
  out.regressors = beside(out.regressors, departures_of(out, interval));
  return out;
}

/// A local quadratic within a gap of the readings extrapolates: where the gap is longer than half a window, there is no
/// temperature in it.
void blank_gaps(const Slice& readings, double half, Smoothed& smooth) {
  double before = readings.time.front();
  std::size_t last = 0;
  for (std::size_t k = 0; k < readings.time.size(); ++k) {
    if (std::isnan(readings.value[k])) continue;
    if (readings.time[k] - before > std::max(half, 3.0 * reading_spacing(readings.time)))
      for (std::size_t i = last + 1; i < k; ++i) smooth.value[i] = smooth.slope[i] = smooth.curvature[i] = std::nan("");
    before = readings.time[k];
    last = k;
  }
}

}  // namespace

Thermal thermal_of(const Sensors& sensors, double begin, double end, const Settings& settings, double lag) {
  const double half = 0.5 * settings.number("smoothing");
  const Slice top = slice(*sensors.top, begin, end);
  if (top.time.empty()) throw Error(Error::Kind::bad_data, say("channel {}: no sample in the run", sensors.top->name));
  Smoothed smooth = local_quadratic(top.time, top.value, half);
  blank_gaps(top, half, smooth);
  Smoothed other = smooth;
  if (sensors.side != nullptr) {
    const Slice side = slice(*sensors.side, begin, end);
    if (side.time.empty())
      throw Error(Error::Kind::bad_data, say("channel {}: no sample in the run", sensors.side->name));
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
    felt.temperature_rate = 0.5 * (smooth.slope[k] + other.slope[k] + lag * (smooth.curvature[k] + other.curvature[k]));
    felt.temperature = 0.5 * (smooth.value[k] + other.value[k] + lag * (smooth.slope[k] + other.slope[k]));
    felt.temperature_gradient = smooth.value[k] - other.value[k] + lag * (smooth.slope[k] - other.slope[k]);
    felt.since_power_on = out.time[k] - from;
    if (felt.since_power_on < settings.number("start_window") - stamp_slack(out.time[k], 0.0) &&
        !std::isnan(felt.temperature)) {
      sum += felt.temperature;
      ++count;
    }
  }
  if (count == 0)
    throw Error(Error::Kind::bad_data, say("channel {}: no temperature in the start window", sensors.top->name));
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

std::vector<RunData> run_data(const Evidence& evidence, const std::vector<Term>& terms, double lag, double interval) {
  const auto runs = runs_of(evidence.recordings);
  std::vector<RunData> out(runs.size());
  std::vector<double> spacing;  // [s] of the gyro's clock in each recording
  for (const Recording& recording : evidence.recordings)
    spacing.push_back(1.0 / sampling_rate(require_channel(evidence, recording, "gyro")));
  parallel_for(runs.size(), [&](std::size_t r) {
    out[r] = data_of(evidence, runs[r], terms, lag, interval, spacing[runs[r].recording]);
  });
  return out;
}

Settings constants_of(const Settings& settings) {
  Settings constants;
  constants.set_number("start_temperature_reference", settings.number("start_temperature_reference"),
                       Unit::parse("degC"));
  constants.set_word("form", settings.word("form"));
  // Without the option the transient's column is not used; any time keeps its regressor defined.
  constants.set_number("startup_time", settings.has("startup_time") ? settings.number("startup_time") : 1.0,
                       Unit::parse("s"));
  return constants;
}

}  // namespace tumble::fog_thermal_bias
