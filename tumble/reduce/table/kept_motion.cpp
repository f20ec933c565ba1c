#include "tumble/reduce/table/kept_motion.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::table {
namespace {

/// [rad] by which axes that have arrived creep and their encoders err over a turn.
constexpr double lies_on_motion = 20.0 * arcsecond;
constexpr double finest_on_motion =
    2.0 * arcsecond;                             ///< [rad] where the scatter over a turn holds what the encoder errs
constexpr double steps_of_reading = 3.0;         ///< [steps] that noise and rounding move a reading
constexpr double sd_of_reading = 6.0;            ///< [sd] one of a million readings is off by chance
constexpr double most_scatter = 1e-3;            ///< [rad] about the fit: with more the window holds another motion
constexpr double most_creep = 36.0 * arcsecond;  ///< [rad] over the window, of an axis that stands
constexpr double of_amplitude = 2e-3;            ///< [1] of an oscillation that drives distort
constexpr double most_of_amplitude = 0.02;  ///< [1] scatter about an oscillation: with more there is another motion
constexpr std::size_t fewest_in_window = 5, most_in_window = 2000;  ///< [readings]
constexpr int in_succession = 3;                                    ///< [readings] a single one may be off by chance
/// [thirds of the segment] where the window that is fitted begins: the middle one first.
constexpr double window_places[] = {1.0, 0.5, 1.5, 0.0, 2.0};

struct Reading {
  double time = 0.0, angle = 0.0;  ///< [s, since the middle], [rad]
};

/// How far [rad] a reading lies from the motion, and how far it may.
struct Distance {
  double off = 0.0, allowed = 0.0;
};
using Judge = std::function<Distance(const Reading&)>;

/// An angle and a rate near `rate` [rad/s].
std::optional<Judge> judge_of_rate(const std::vector<Reading>& window, double rate, double step) {
  const Reading& origin = window[window.size() / 2];
  const auto off_plan = [=](const Reading& reading) {
    return std::remainder(reading.angle - origin.angle - rate * (reading.time - origin.time), two_pi);
  };
  const auto n = static_cast<double>(window.size());
  double mean_t = 0.0, mean_x = 0.0, tt = 0.0, tx = 0.0, xx = 0.0;
  for (const Reading& reading : window) {
    mean_t += reading.time / n;
    mean_x += off_plan(reading) / n;
  }
  for (const Reading& reading : window) {
    const double t = reading.time - mean_t, x = off_plan(reading) - mean_x;
    tt += t * t;
    tx += t * x;
    xx += x * x;
  }
  const double slope = tx / tt, sd = std::sqrt(std::max(xx - slope * tx, 0.0) / (n - 2.0));
  if (!(sd < most_scatter)) return {};
  const double creep = slope * (window.back().time - window.front().time);
  if (rate == 0.0 && std::abs(creep) > most_creep) return {};
  // over whole turns the scatter shows how far the encoder errs
  const bool turns = std::abs(rate) * (window.back().time - window.front().time) > two_pi;
  const double floor = turns ? finest_on_motion : lies_on_motion;
  return [=](const Reading& reading) {
    const double t = reading.time - mean_t;
    const double off = std::remainder(off_plan(reading) - mean_x - slope * t, two_pi);
    return Distance{off, floor + steps_of_reading * step + sd_of_reading * sd * std::sqrt(1.0 + 1.0 / n + t * t / tt)};
  };
}

std::optional<Judge> judge_of_sine(const std::vector<Reading>& window, const Motion& motion, double step) try {
  std::vector<double> times, angles;
  for (const Reading& reading : window) {
    times.push_back(reading.time);
    angles.push_back(angles.empty() ? reading.angle
                                    : angles.back() + std::remainder(reading.angle - angles.back(), two_pi));
  }
  const SineFit fit = fit_sine(times, angles, motion.frequency, {.polynomial = 0, .fit_frequency = true});
  const double amplitude = std::abs(fit.line[0]);
  if (!(fit.residual_rms < most_of_amplitude * amplitude)) return {};
  return [=](const Reading& reading) {
    const double t = reading.time - fit.centre;
    const double fitted = std::real(fit.line[0] * std::polar(1.0, two_pi * fit.frequency * t)) + fit.polynomial[0];
    const double by_frequency = two_pi * fit.frequency_sd * std::abs(t) * amplitude;
    return Distance{std::remainder(reading.angle - fitted, two_pi),
                    lies_on_motion + steps_of_reading * step + of_amplitude * amplitude +
                        sd_of_reading * std::hypot(2.0 * fit.residual_rms, by_frequency)};
  };
} catch (const Error& error) {
  if (error.kind != Error::Kind::bad_data) throw;
  return {};
}

std::optional<Judge> judge_of(const Encoder& encoder, const Motion* motion, const std::vector<Reading>& window) {
  using Kind = Motion::Kind;
  if (window.size() < fewest_in_window) return {};
  if (motion == nullptr || motion->kind == Kind::hold) return judge_of_rate(window, 0.0, encoder.step);
  if (motion->kind == Kind::rate) return judge_of_rate(window, motion->value, encoder.step);
  if (motion->kind == Kind::sine) return judge_of_sine(window, *motion, encoder.step);
  return {};
}

/// The readings of a channel whose samples lie in a segment wholly.
struct SegmentReadings {
  const Channel& channel;
  double step, middle;      ///< [s]
  std::size_t first, last;  ///< indices, first <= i < last

  SegmentReadings(const Channel& of, double begin, double end) : channel(of), step(1.0 / mean_rate(of)) {
    const double slack = stamp_slack(end, step);
    first = last = index_at(channel, begin - slack);
    while (last < channel.values.size() && time(last) + step < end + slack) ++last;
    middle = first < channel.values.size() ? time(first + (last - first) / 2) : 0.0;
  }
  double time(std::size_t i) const { return channel.time(i); }
  Reading at(std::size_t i) const { return {time(i) - middle, channel.values[i]}; }
  std::vector<Reading> between(std::size_t begin, std::size_t end) const {
    std::vector<Reading> out;
    for (std::size_t i = begin; i < end; i += 1 + (end - begin) / most_in_window)
      if (!std::isnan(channel.values[i])) out.push_back(at(i));
    return out;
  }
  /// The last reading on the motion, from one of the window on to an end of the segment.
  std::size_t reach(std::size_t from, int towards, const Judge& judge) const {
    std::size_t good = from;
    int bad = 0;
    for (std::size_t i = from; i >= first && i < last && bad < in_succession; i += static_cast<std::size_t>(towards)) {
      const Distance distance = std::isnan(channel.values[i]) ? Distance{} : judge(at(i));
      bad = std::abs(distance.off) <= distance.allowed ? 0 : bad + 1;
      if (bad == 0) good = i;
    }
    return good;
  }
};

}  // namespace

Kept kept_motion(const Encoder& encoder, const Motion* motion, double begin, double end) {
  const SegmentReadings readings(*encoder.channel, begin, end);
  const std::size_t third = (readings.last - readings.first) / 3;
  const Kept all{begin, end};
  if (third < fewest_in_window) return all;
  std::size_t window = readings.first;
  std::optional<Judge> judge;
  for (const double place : window_places) {
    window = readings.first + static_cast<std::size_t>(place * static_cast<double>(third));
    if ((judge = judge_of(encoder, motion, readings.between(window, window + third)))) break;
  }
  if (!judge) return all;
  const std::size_t from = readings.reach(window, -1, *judge), until = readings.reach(window + third - 1, 1, *judge);
  return {from == readings.first ? begin : readings.time(from) + readings.step,
          until + 1 == readings.last ? end : readings.time(until)};
}

}  // namespace tumble::table
