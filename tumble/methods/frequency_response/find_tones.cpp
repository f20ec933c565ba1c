#include <algorithm>
#include <cmath>

#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/methods/frequency_response/point.hpp"
#include "tumble/units/error.hpp"

namespace tumble::frequency_response {
namespace {

constexpr std::size_t fewest_of_block = 16;  ///< samples, in which a frequency is estimated
constexpr double pause_swing = 0.05;         ///< [1] of the greatest swing, below which a block is a pause
/// [1/length of a block] and [1], by which blocks of one tone differ in frequency: the estimate is good to a few
/// tenths.
constexpr double steady_bins = 0.3, steady_share = 2e-3;
/// [1] of the steps from block to block, that go one way in a sweep: of 99 random steps more do with p = 2e-5.
constexpr std::size_t sweep_of_ten = 7;
/// [1] of the amplitude, above which a residual is no noise of one tone: that of two equal tones is 0.7.
constexpr double tone_residual = 0.35;
constexpr std::size_t fewest_to_explore = 32;  ///< samples

constexpr std::size_t blocks = 100;
constexpr double same_tone = 0.02;  ///< [1] by which a tone may be off the planned frequency
/// Tones that are off the plan alike: [1], five times what plain oscillators are off by; scatter [1] of that; and number of tones.
constexpr double clock_apart = 5e-4, scatter_of_clock = 0.2;
constexpr std::size_t fewest_of_clock = 3;

/// The strongest frequency of the reference in each block; 0 where it does not move.
struct Blocks {
  std::vector<double> frequency;
  double length = 0.0, begin = 0.0;
};

Blocks blocks_of(const Samples& reference) {
  Blocks b;
  const std::size_t size = reference.value.size() / blocks;
  b.begin = reference.time.front();
  b.length = static_cast<double>(size) / reference.rate;
  if (size < fewest_of_block) return b;
  std::vector<double> swing;
  for (std::size_t k = 0; k < blocks; ++k) {
    const std::span<const double> part(reference.value.data() + k * size, size);
    double low = INFINITY, high = -INFINITY, frequency = 0.0;
    for (const double v : part)
      if (!std::isnan(v)) low = std::min(low, v), high = std::max(high, v);
    try {
      frequency = strongest_frequency(part, reference.rate);
    } catch (const Error&) {
    }
    swing.push_back(high > low ? high - low : 0.0);
    b.frequency.push_back(frequency);
  }
  const double greatest = *std::max_element(swing.begin(), swing.end());
  for (std::size_t k = 0; k < blocks; ++k)
    if (swing[k] < pause_swing * greatest) b.frequency[k] = 0.0;  // a pause
  return b;
}

/// Runs of three blocks or more at one frequency, without the first and last block where the frequency changes.
std::vector<std::pair<double, double>> steady_parts(const Blocks& b, std::size_t& covered) {
  std::vector<std::pair<double, double>> parts;
  covered = 0;
  for (std::size_t first = 0, k = 1; k <= b.frequency.size(); ++k) {
    const bool steady =
        k < b.frequency.size() && b.frequency[k] > 0.0 &&
        std::abs(b.frequency[k] - b.frequency[first]) < std::max(steady_bins / b.length, steady_share * b.frequency[k]);
    if (steady) continue;
    if (k - first >= 3 && b.frequency[first] > 0.0) {
      covered += k - first;
      const double from = static_cast<double>(first + (first > 0 ? 1 : 0)) * b.length;
      const double to = static_cast<double>(k - (k < b.frequency.size() ? 1 : 0)) * b.length;
      parts.emplace_back(b.begin + from, b.begin + to);
    }
    first = k;
  }
  return parts;
}

bool is_sweep(const Blocks& b) {
  std::size_t up = 0, down = 0;
  for (std::size_t k = 1; k < b.frequency.size(); ++k) {
    up += b.frequency[k] > b.frequency[k - 1];
    down += b.frequency[k] < b.frequency[k - 1];
  }
  return std::max(up, down) > sweep_of_ten * b.frequency.size() / 10;
}

bool is_tone(const Samples& reference) {
  try {
    const double f = strongest_frequency(reference.value, reference.rate);
    const SineFit fit = fit_sine(reference.time, reference.value, f, {.fit_frequency = true, .rate = reference.rate});
    return fit.residual_rms < tone_residual * std::abs(fit.line[0]);
  } catch (const Error&) {
    return false;
  }
}

/// A part without a plan: one tone, several tones in succession, or a sweep.
void explore(const Part& part, const Scaling& scaling, const Settings& settings, Points& points) {
  const Samples reference = samples_of(part.reference, part.begin, part.end, scaling.reference_shift);
  if (reference.time.size() < fewest_to_explore || is_tone(reference)) {
    add_tone(part, part.begin, part.end, scaling, settings, points);
    return;
  }
  const Blocks b = blocks_of(reference);
  std::size_t covered = 0;
  const auto parts = steady_parts(b, covered);
  if (covered > b.frequency.size() / 2) {
    for (const auto& [begin, end] : parts) add_tone(part, begin, end, scaling, settings, points);
  } else if (is_sweep(b)) {
    add_sweep(part, scaling, settings, points);
  } else {
    points.findings.push_back({Finding::Severity::error, "unknown_excitation", {}, part.label});
  }
}

bool is_near(double frequency, double planned) { return std::abs(frequency / planned - 1.0) < same_tone; }

/// Skips points whose tone is not the planned one and is that of another segment.
void drop_others(const Data& data, Points& points) {
  std::erase_if(points.usable, [&](const Point& point) {
    const auto is_of = [&](const Part& part) {
      return part.motion && part.motion->kind == Motion::Kind::sine && is_near(point.frequency, part.motion->frequency);
    };
    const auto other = std::ranges::find_if(data.parts, is_of);
    if (is_near(point.frequency, point.nominal) || other == data.parts.end()) return false;
    points.findings.push_back(
        {Finding::Severity::error,
         "tone_of_another_segment",
         {{"planned", point.nominal, "Hz"}, {"measured", point.frequency, "Hz"}, {"other", other->label}},
         point.where});
    return true;
  });
}

/// A finding where all tones are off the plan by one factor: the clock of the record or of the shaker is wrong.
void check_clock(const Data& data, Points& points) {
  double sum = 0.0, squares = 0.0, n = 0.0;
  const Point* highest = nullptr;
  for (const Point& point : points.usable) {
    if (point.cycles == 0.0 || !is_near(point.frequency, point.nominal)) continue;
    const auto planned = std::ranges::find(data.parts, point.where, &Part::label);
    if (planned == data.parts.end() || !planned->motion) continue;
    const double off = point.frequency / planned->motion->frequency - 1.0;
    sum += off, squares += off * off, ++n;
    if (highest == nullptr || point.frequency > highest->frequency) highest = &point;
  }
  if (n < static_cast<double>(fewest_of_clock)) return;
  const double mean = sum / n, scatter = std::sqrt(std::max(0.0, squares / n - mean * mean));
  if (std::abs(mean) < clock_apart || scatter > scatter_of_clock * std::abs(mean)) return;
  points.findings.push_back({Finding::Severity::warning,
                             "frequencies_differ_alike",
                             {{"difference", mean, "ppm"}, {"frequency", highest->frequency, "Hz"}}});
}

}  // namespace

Points points_of(const Data& data, const Settings& settings, const Progress& progress) {
  Points points;
  double done = 0.0;
  for (const Part& part : data.parts) {
    report(progress, done++ / static_cast<double>(data.parts.size()), "tones");
    if (!part.motion) {
      explore(part, data.scaling, settings, points);
    } else if (part.motion->kind == Motion::Kind::sweep) {
      add_sweep(part, data.scaling, settings, points);
    } else {
      add_tone(part, part.begin, part.end, data.scaling, settings, points);
    }
  }
  drop_others(data, points);
  check_clock(data, points);
  std::stable_sort(points.usable.begin(), points.usable.end(),
                   [](const Point& a, const Point& b) { return a.frequency < b.frequency; });
  return points;
}

}  // namespace tumble::frequency_response
