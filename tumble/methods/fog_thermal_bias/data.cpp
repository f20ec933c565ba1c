#include "tumble/methods/fog_thermal_bias/data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/methods/fog_thermal_bias/departures.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/reduce/thermal/thermal.hpp"
#include "tumble/units/error.hpp"

namespace tumble::fog_thermal_bias {
namespace {

/// [1] of the samples and of the readings that an average needs: half of the samples; of the readings what is missing
/// at one end of an interval.
constexpr double least_samples = 0.5, least_readings = 0.9;

double mean_of(const Slice& s, double until, const std::string& what) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t k = 0; k < s.time.size() && s.time[k] < until - stamp_slack(until, 0.0); ++k) {
    if (std::isnan(s.value[k])) continue;
    sum += s.value[k];
    ++count;
  }
  if (count == 0) throw Error(Error::Kind::bad_data, say("{}: no sample in the start window", Name{what}));
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

/// Which part of the gyro's samples about each thermal reading was measured: where the gyro has a gap, its mean is that
/// of the rest of the interval, and so must be the mean of the temperatures. Empty: all were.
std::vector<double> measured_about(const Slice& gyro, const std::vector<double>& readings, double spacing) {
  std::vector<double> times;
  for (std::size_t k = 0; k < gyro.time.size(); ++k)
    if (!std::isnan(gyro.value[k])) times.push_back(gyro.time[k]);
  if (times.empty() || readings.size() < 2) return {};
  const double expected = (times.back() - times.front()) / spacing + 1.0;
  if (static_cast<double>(times.size()) > expected - 0.5) return {};
  const double half = 0.5 * std::max(spacing, reading_spacing(readings)) * (1.0 + rounding_share);
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
  const double full_readings = std::floor(interval / reading_spacing(thermal.time) + rounding_share);
  for (std::size_t k = 0; k < count; ++k) {
    run.time[k] = (static_cast<double>(k) + 0.5) * interval;
    const bool covered = readings[k] >= least_readings * std::min(1.0, samples[k] / full) * full_readings;
    const bool usable = samples[k] >= least_samples * full && readings[k] > 0.0 && covered;
    run.share[k] = usable ? std::min(1.0, samples[k] / full) : 0.0;
    const double per = readings[k] > 0.0 ? 1.0 / readings[k] : 0.0;
    run.output[k] = usable ? run.output[k] / samples[k] : 0.0;
    run.felt[k].temperature *= per;
    run.felt[k].temperature_gradient *= per;
    run.felt[k].temperature_rate *= per;
    for (std::size_t t = 0; t < terms.size(); ++t) run.regressors(k, t) *= usable ? per : 0.0;
  }
}

/// Steps of the readings at the end of a power-up among which that to the next is looked for, and how large it is: over
/// the largest step before, and in K. No chamber moves so fast.
constexpr std::size_t steps_at_end = 20, fewest_readings_of_run = 200;
constexpr double over_largest_step = 10.0, least_step_to_next = 1.0;

/// End [s] of what belongs to the power-up: where the mark of the next one is late, its last readings are those of the
/// next, at another temperature.
double own_end(const Run& run, const Channel& thermometer) {
  const Slice readings = slice(thermometer, run.begin, run.end);
  const std::size_t n = readings.value.size();
  if (n < fewest_readings_of_run) return run.end;
  double largest = 0.0;
  for (std::size_t k = 1; k < n; ++k) {
    const double step = std::abs(readings.value[k] - readings.value[k - 1]);
    if (k + steps_at_end >= n && step > std::max(over_largest_step * largest, least_step_to_next))
      return 0.5 * (readings.time[k - 1] + readings.time[k]);
    if (step > largest) largest = step;
  }
  return run.end;
}

/// Begin [s] of the temperatures that belong to the power-up: where the thermometers are stamped late, its first readings are
/// those of the power-up before, at another temperature.
double own_begin(const Run& run, const Channel& thermometer) {
  const Slice readings = slice(thermometer, run.begin, run.end);
  const std::size_t n = readings.value.size();
  if (n < fewest_readings_of_run || !std::isfinite(run.begin)) return run.begin;
  double largest = 0.0;
  for (std::size_t k = n - 1; k > 0; --k) {
    const double step = std::abs(readings.value[k] - readings.value[k - 1]);
    if (k <= steps_at_end && step > std::max(over_largest_step * largest, least_step_to_next))
      return 0.5 * (readings.time[k - 1] + readings.time[k]);
    if (step > largest) largest = step;
  }
  return run.begin;
}

/// Time [s] of the last sample of a power-up.
double end_of(const Channel& channel, const Run& run) {
  const Slice samples = slice(channel, run.begin, run.end);
  return samples.time.empty() ? run.end : samples.time.back();
}

RunData data_of(const Evidence& evidence, const Run& marked, const std::vector<Term>& terms, double lag,
                double interval, double spacing) {
  const Settings& settings = evidence.plan.settings;
  const Signals role = signals_of(evidence, evidence.recordings[marked.recording]);
  Run run = marked;
  run.end = own_end(marked, *role.sensors.top);
  const std::string where = fmt::format("run {}{}", run.number, run.label.empty() ? "" : " (" + run.label + ")");
  const Slice gyro = slice(*role.gyro, run.begin, run.end);
  if (gyro.time.size() < 2)
    throw Error(Error::Kind::bad_data, say("{}: fewer than two samples of {}", Name{where}, Name{role.gyro->name}));
  const double begin = std::isfinite(run.begin) ? run.begin : gyro.time.front();
  const double own = own_begin(run, *role.sensors.top);
  const Thermal thermal = thermal_of(role.sensors, own, run.end, reading_of(settings, lag));
  RunData out;
  out.number = run.number;
  out.label = run.label;
  out.recording = run.recording;
  out.file = evidence.recordings[run.recording].origin.file;
  out.of_next = run.end < marked.end ? end_of(*role.gyro, marked) - run.end : 0.0;
  out.of_last = own > run.begin ? own - run.begin : 0.0;
  out.begin = begin;
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
                    Name{where}, gyro.time.back() - gyro.time.front(), Name{role.gyro->name}, interval));
  out.regressors = beside(out.regressors, departures_of(out, interval));
  return out;
}

}  // namespace

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

ThermalReading reading_of(const Settings& settings, double lag) {
  return {settings.number("smoothing"), lag, settings.number("start_window"), settings.number("averaging")};
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
