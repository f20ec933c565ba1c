#include "tumble/methods/imu_ferraris/turned.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tumble/math/median.hpp"
#include "tumble/math/square.hpp"

namespace tumble::imu_ferraris {
namespace {

/// [1] of the usual interval: a longer one has lost a sample. Stamps scatter by less than half an interval.
constexpr double longest_interval = 1.5;

struct Sample {
  double time, value;
};

std::vector<Sample> samples_in(const Channel& channel, std::size_t begin, std::size_t end) {
  std::vector<Sample> samples;
  for (std::size_t i = begin; i < end; ++i)
    if (!std::isnan(channel.values[i])) samples.push_back({channel.time(i), channel.values[i]});
  return samples;
}

double usual_interval(const Channel& channel, std::size_t begin, std::size_t end) {
  if (channel.timeline.uniform()) return 1.0 / channel.timeline.rate;
  std::vector<double> intervals;
  for (std::size_t i = begin + 1; i < end; ++i) intervals.push_back(channel.time(i) - channel.time(i - 1));
  return intervals.empty() ? 0.0 : median(intervals);
}

/// The mean square [output^2 s^2] of what a straight line over `length` [s] is wrong by, where the samples are there;
/// where the part is too short to try it, the whole range of the output may have been passed.
double error_of_line(const std::vector<Sample>& samples, double usual, double length) {
  const auto width = static_cast<std::size_t>(std::max(1.0, std::round(length / usual)));
  double squares = 0.0, count = 0.0;
  for (std::size_t first = 1; first + width < samples.size(); first += std::max<std::size_t>(1, width / 2)) {
    const Sample &before = samples[first - 1], &after = samples[first + width];
    const double steps = static_cast<double>(width) + 1.0;
    if (after.time - before.time > (steps + longest_interval - 1.0) * usual) continue;  // it has a gap itself
    double sum = 0.0;
    for (std::size_t i = first; i < first + width; ++i) sum += samples[i].value;
    squares += square(usual * (sum - 0.5 * static_cast<double>(width) * (before.value + after.value)));
    ++count;
  }
  if (count > 0.0) return squares / count;
  const auto [least, most] = std::ranges::minmax(samples, {}, &Sample::value);
  return square((most.value - least.value) * length) / 12.0;
}

constexpr std::size_t part_at_end = 20, fewest_at_end = 8;  ///< a twentieth of a part; samples
/// [1] Variance over half the mean square of the steps between neighbours: 1 for white noise, with an sd of 0.4 for 8 samples.
constexpr double still_below = 3.0;

TurnEnd end_of(const std::vector<Sample>& samples, std::size_t first, std::size_t count) {
  TurnEnd out;
  for (std::size_t i = first; i < first + count; ++i) out.mean += samples[i].value / static_cast<double>(count);
  double squares = 0.0, steps = 0.0;
  for (std::size_t i = first; i < first + count; ++i) {
    squares += square(samples[i].value - out.mean);
    if (i > first) steps += square(samples[i].value - samples[i - 1].value);
  }
  out.samples = static_cast<double>(count);
  out.still = squares <= still_below * 0.5 * steps;
  return out;
}

}  // namespace

std::array<TurnEnd, 2> ends_of(const Channel& channel, std::size_t begin, std::size_t end) {
  const auto samples = samples_in(channel, begin, end);
  const std::size_t count = std::max(fewest_at_end, samples.size() / part_at_end);
  if (samples.size() < 4 * count) return {};
  return {end_of(samples, 0, count), end_of(samples, samples.size() - count, count)};
}

Turned turned_in(const Channel& channel, std::size_t begin, std::size_t end, double from, double to) {
  Turned turned;
  const auto samples = samples_in(channel, begin, end);
  const double usual = usual_interval(channel, begin, end);
  if (samples.empty() || !(usual > 0.0)) return turned;
  const auto bridge = [&](double first, double second, double length) {
    turned.total += 0.5 * (first + second) * length;
    if (length < (longest_interval - 1.0) * usual) return;
    turned.bridged += length;
    turned.variance += error_of_line(samples, usual, length);
  };
  const Sample &first = samples.front(), &last = samples.back();
  bridge(first.value, first.value, first.time - from);
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    const double interval = samples[i + 1].time - samples[i].time;
    const bool whole = interval <= longest_interval * usual;
    turned.total += samples[i].value * (whole ? interval : usual);
    if (!whole) bridge(samples[i].value, samples[i + 1].value, interval - usual);
  }
  turned.total += last.value * usual;
  if (std::isfinite(to)) bridge(last.value, last.value, to - last.time - usual);
  return turned;
}

}  // namespace tumble::imu_ferraris
