#include "tumble/methods/sine_vibration/steady.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::sine_vibration {
namespace {

using Severity = Finding::Severity;
using vibration::Data;
using vibration::Series;

constexpr std::size_t blocks = 20;
constexpr std::size_t fewest_windows = 16;  ///< present in a block
/// [1] of the greatest value that the normal equations of a block may have: near half of the rate sine and cosine are one.
constexpr double least_pivot = 0.1;
constexpr double ramp_sd = 8.0;  ///< [sd] of a change: p = 1e-7 with 20 blocks
/// [1] of the tone: where the shaker is not up; change of its level, or of a unit without a reference; change of a gain.
constexpr double least_absent = 0.05, least_ramp = 0.02, least_gain_change = 5e-3;
constexpr double over_rest = 5.0;  ///< of the fastest drift at rest
constexpr std::size_t fewest_rests = 2;

/// A tone by blocks; NaN where a block does not show it.
struct Course {
  std::vector<double> amplitude, mean;
};

/// Adds a block: v = a cos + b sin + m.
void add_block(const Series& series, const std::vector<double>& values, std::size_t from, std::size_t to,
               Course& course) {
  Matrix normal(3, 3);
  std::vector<double> right(3, 0.0);
  double count = 0.0;
  for (std::size_t j = from; j < to; ++j) {
    if (!std::isfinite(values[j])) continue;
    const double angle = two_pi * series.shake.frequency * series.time[j];
    const std::array<double, 3> row{std::cos(angle), std::sin(angle), 1.0};
    for (std::size_t a = 0; a < row.size(); ++a) {
      right[a] += values[j] * row[a];
      for (std::size_t b = 0; b < row.size(); ++b) normal(a, b) += row[a] * row[b];
    }
    ++count;
  }
  const double c = normal(0, 0), s = normal(1, 1), x = normal(0, 1);
  course.amplitude.push_back(NAN), course.mean.push_back(NAN);
  if (count < static_cast<double>(fewest_windows) || !(c * s - x * x > least_pivot * 0.25 * count * count)) return;
  const auto fit = solve_symmetric(normal, right);
  course.amplitude.back() = std::hypot(fit[0], fit[1]);
  course.mean.back() = fit[2];
}

Course course_of(const Series& series, const std::vector<double>& values) {
  Course course;
  for (std::size_t k = 0; k < blocks && !values.empty(); ++k)
    add_block(series, values, k * values.size() / blocks, (k + 1) * values.size() / blocks, course);
  return course;
}

double median_present(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  return values.empty() ? NAN : median(std::move(values));
}

/// A change along the segment and its sd, by the scatter about a line; zero where blocks are missing.
struct Change {
  double size = 0.0, sd = 0.0;
  bool is_seen(double least) const { return std::abs(size) > std::max(ramp_sd * sd, least); }
};

Change change_of(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double level = 0.0, squares = 0.0, products = 0.0, left = 0.0;
  for (const double v : values) level += v / n;
  const auto place = [&](std::size_t k) { return (static_cast<double>(k) + 0.5) / n - 0.5; };
  for (std::size_t k = 0; k < values.size(); ++k)
    squares += place(k) * place(k), products += place(k) * (values[k] - level);
  if (values.size() < blocks || !std::isfinite(products)) return {};
  const double change = products / squares;
  for (std::size_t k = 0; k < values.size(); ++k) left += std::pow(values[k] - level - change * place(k), 2);
  return {change, std::sqrt(left / (n - 2.0) / squares)};
}

std::vector<double> logarithm(const std::vector<double>& values) {
  std::vector<double> out;
  for (const double v : values) out.push_back(v > 0.0 ? std::log(v) : NAN);
  return out;
}

/// Blocks at the beginning in which the shaker is not up: by 5 % and by more than the others scatter.
template <class Blocks>
std::size_t absent(const Blocks& amplitudes, double usual, double scatter) {
  std::size_t count = 0;
  for (const double one : amplitudes) {
    if (!(one < usual - std::max(least_absent * usual, ramp_sd * scatter))) break;
    ++count;
  }
  return count;
}

void cut(std::size_t first, std::size_t last, Series& series) {
  for (std::vector<double>* values : {&series.time, &series.force, &series.reference}) {
    if (values->empty()) continue;
    *values = std::vector<double>(values->begin() + static_cast<std::ptrdiff_t>(first),
                                  values->end() - static_cast<std::ptrdiff_t>(last));
  }
  series.begin += static_cast<double>(first) * series.interval;
  series.end -= static_cast<double>(last) * series.interval;
}

/// Cuts a tone, with one block more: in it the shaker comes up or stops.
void cut_to_tone(Series& series, Findings& findings) {
  const std::vector<double> amplitude = course_of(series, series.force).amplitude;
  const double usual = median_present(amplitude);
  std::vector<double> off;
  for (const double one : amplitude) off.push_back(std::abs(one - usual));
  const double scatter = sd_of_median_size * median_present(off);
  std::size_t begin = absent(amplitude, usual, scatter);
  std::size_t end = absent(std::vector<double>(amplitude.rbegin(), amplitude.rend()), usual, scatter);
  if (begin + end == 0 || 2 * (begin + end) >= blocks) return;
  const auto windows = [&](std::size_t count) { return count > 0 ? (count + 1) * series.force.size() / blocks : 0; };
  begin = windows(begin), end = windows(end);
  cut(begin, end, series);
  vibration::add_once({Severity::warning,
                       "vibration_not_throughout",
                       {{"begin", static_cast<double>(begin) * series.interval, "s"},
                        {"end", static_cast<double>(end) * series.interval, "s"}},
                       series.label},
                      findings);
}

/// Fastest drift of a unit at rest [m/s^3], and the number of its rests.
struct RestDrift {
  double fastest = 0.0;
  std::size_t rests = 0;
};

RestDrift drift_at_rest(const Data& data, std::size_t unit) {
  RestDrift drift;
  for (const Series& series : data.series) {
    if (!series.at_rest() || series.unit != unit || series.force.size() < blocks * fewest_windows) continue;
    std::vector<double> means;
    for (std::size_t k = 0; k < blocks; ++k) {
      double sum = 0.0, count = 0.0;
      for (std::size_t j = k * series.force.size() / blocks; j < (k + 1) * series.force.size() / blocks; ++j)
        if (std::isfinite(series.force[j])) sum += series.force[j], ++count;
      means.push_back(sum / count);
    }
    drift.fastest = std::max(drift.fastest, std::abs(change_of(means).size) / (series.end - series.begin));
    ++drift.rests;
  }
  return drift;
}

void judge(const Data& data, const Series& series, Findings& findings) {
  const Course own = course_of(series, series.force), motion = course_of(series, series.reference);
  const Change level = change_of(logarithm(motion.amplitude.empty() ? own.amplitude : motion.amplitude));
  if (level.is_seen(least_ramp))
    vibration::add_once({Severity::warning,
                         "vibration_not_steady",
                         {{"change", std::expm1(level.size), "%"}},
                         motion.amplitude.empty() ? place_of(data, series) : series.label},
                        findings);
  if (!motion.amplitude.empty()) {
    std::vector<double> ratio;
    for (std::size_t k = 0; k < own.amplitude.size(); ++k) ratio.push_back(own.amplitude[k] / motion.amplitude[k]);
    const Change gain = change_of(logarithm(ratio));
    if (gain.is_seen(least_gain_change))
      findings.push_back({Severity::warning,
                          "gain_changes_in_tone",
                          {{"change", std::expm1(gain.size), "%"}},
                          place_of(data, series)});
  }
  const RestDrift rest = drift_at_rest(data, series.unit);
  const Change mean = change_of(own.mean);
  if (rest.rests >= fewest_rests && mean.is_seen(over_rest * rest.fastest * (series.end - series.begin)))
    findings.push_back(
        {Severity::warning, "mean_drifts_in_tone", {{"change", mean.size, "mg"}}, place_of(data, series)});
}

}  // namespace

void check_steadiness(Data& data) {
  for (Series& series : data.series) {
    if (series.shake.kind != Motion::Kind::sine || series.force.size() < blocks * fewest_windows) continue;
    cut_to_tone(series, data.findings);
    if (series.force.size() >= blocks * fewest_windows) judge(data, series, data.findings);
  }
}

}  // namespace tumble::sine_vibration
