#include "tumble/reduce/linear/in_time.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/square.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::linear {
namespace {

constexpr std::size_t fewest_beside = 2;       ///< averages on either side of a step: a single one is an outlier
constexpr double waves_apart = 0.5;            ///< [waves over the test] from one that is tried to the next
constexpr std::size_t most_waves_tried = 100;  ///< over the whole test
/// Segments of three averages and more: fewer let a wave bend through all of them.
constexpr std::size_t fewest_segments = 6, fewest_averages = 3;

/// The rows of one segment in which what is felt stays the same.
struct SegmentAverages {
  std::size_t first = 0, end = 0;
};

std::vector<SegmentAverages> uniform_segments(const Work& work, std::size_t fewest) {
  std::vector<SegmentAverages> all;
  const auto& segment = work.rows.segment;
  for (std::size_t first = 0, end = 0; first < segment.size(); first = end) {
    while (end < segment.size() && segment[end] == segment[first]) ++end;
    if (end - first >= fewest && work.evidence.uniform(segment[first])) all.push_back({first, end});
  }
  return all;
}

/// Weighted sums.
struct WeightedSums {
  double weight = 0.0, sum = 0.0;
  void add(double w, double value) { weight += w, sum += w * value; }
};

/// The gain of the square sum where a segment has a mean on either side of row `at`.
double gain_of_step(const Work& work, const std::vector<double>& left, const SegmentAverages& rows, std::size_t at) {
  WeightedSums before, after;
  for (std::size_t i = rows.first; i < rows.end; ++i) (i < at ? before : after).add(work.rows.weights[i], left[i]);
  return square(after.sum / after.weight - before.sum / before.weight) * before.weight * after.weight /
         (before.weight + after.weight);
}

/// Cosine and sine of each row about their means over the segments, and what they explain.
struct WaveFit {
  double cosine = 0.0, sine = 0.0, gain = 0.0;
};

WaveFit fit_wave(const Work& work, const std::vector<Course>& courses, const std::vector<double>& left,
                 const std::vector<SegmentAverages>& segments, double frequency) {
  double cc = 0.0, cs = 0.0, ss = 0.0, cy = 0.0, sy = 0.0;
  for (const auto& rows : segments) {
    WeightedSums c, s, y;
    const auto phase = [&](std::size_t i) { return two_pi * frequency * courses[i].time; };
    for (std::size_t i = rows.first; i < rows.end; ++i) {
      const double w = work.rows.weights[i];
      c.add(w, std::cos(phase(i))), s.add(w, std::sin(phase(i))), y.add(w, left[i]);
    }
    for (std::size_t i = rows.first; i < rows.end; ++i) {
      const double w = work.rows.weights[i], a = std::cos(phase(i)) - c.sum / c.weight,
                   b = std::sin(phase(i)) - s.sum / s.weight, v = left[i] - y.sum / y.weight;
      cc += w * a * a, cs += w * a * b, ss += w * b * b, cy += w * a * v, sy += w * b * v;
    }
  }
  constexpr double least_determinant = 1e-6;  // [1] the two phases do not differ within the segments
  const double determinant = cc * ss - cs * cs;
  if (!(determinant > least_determinant * cc * ss)) return {};
  const double cosine = (ss * cy - cs * sy) / determinant, sine = (cc * sy - cs * cy) / determinant;
  return {cosine, sine, cosine * cy + sine * sy};
}

}  // namespace

StepWithin step_within(const Work& work, const std::vector<double>& left) {
  StepWithin step;
  double most = 0.0;
  std::size_t at = 0;
  for (const auto& rows : uniform_segments(work, 2 * fewest_beside))
    for (std::size_t i = rows.first + fewest_beside; i + fewest_beside <= rows.end; ++i) {
      step.tries += 1.0;
      if (const double gain = gain_of_step(work, left, rows, i); gain > most) most = gain, at = i;
    }
  if (!(most > 0.0)) return {};
  step.segment = work.rows.segment[at];
  const auto& stretches = work.evidence.test.stretches;
  for (std::size_t i = 0; i < left.size(); ++i)
    step.column.push_back(i >= at && stretches[work.rows.segment[i]].start == stretches[step.segment].start ? 1.0
                                                                                                            : 0.0);
  return step;
}

WaveWithin wave_within(const Work& work, const std::vector<Course>& courses, const std::vector<double>& left) {
  const auto segments = uniform_segments(work, fewest_averages);
  if (segments.size() < fewest_segments) return {};
  const auto [begin, end] = std::ranges::minmax(courses, {}, &Course::time);
  const double length = end.time - begin.time, most = 0.5 * static_cast<double>(segments.size());
  if (!(length > 0.0)) return {};
  WaveWithin wave;
  WaveFit best;
  for (std::size_t k = 1; k <= most_waves_tried && waves_apart * static_cast<double>(k) <= most; ++k) {
    const double frequency = waves_apart * static_cast<double>(k) / length;
    const WaveFit fit = fit_wave(work, courses, left, segments, frequency);
    wave.tries += 2.0;  // phases
    if (fit.gain > best.gain) best = fit, wave.period = 1.0 / frequency;
  }
  const double size = std::hypot(best.cosine, best.sine);
  if (!(size > 0.0)) return {};
  for (const Course& course : courses) {
    const double phase = two_pi * course.time / wave.period;
    wave.column.push_back((best.cosine * std::cos(phase) + best.sine * std::sin(phase)) / size);
  }
  return wave;
}

}  // namespace tumble::linear
