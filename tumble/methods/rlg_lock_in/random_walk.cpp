#include "tumble/methods/rlg_lock_in/random_walk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tumble/math/median.hpp"
#include "tumble/math/noise/noise_bands.hpp"
#include "tumble/math/spectrum/sines.hpp"
#include "tumble/math/stability/allan.hpp"
#include "tumble/math/stability/allan_fit.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rlg_lock_in {
namespace {

constexpr std::size_t least_samples = 64;

std::vector<const Point*> usable(const Sweep& sweep) {
  std::vector<const Point*> all, at_rest;
  for (const auto& point : sweep.points) {
    if (!point.dithered || point.beats.size() < least_samples) continue;
    all.push_back(&point);
    if (!point.moving) at_rest.push_back(&point);
  }
  return at_rest.empty() ? all : at_rest;
}

/// Power of a sine over the median of those beside it, which is 0.455 of the mean: by noise with p = 2e-11.
constexpr double power_of_line = 100.0;
constexpr std::size_t ordinates_beside = 40;  ///< whose median is the noise
constexpr int most_dither_lines = 6;

/// The frequency [cycles a sample] that stands out most of what is beside it; 0: none does.
double line_in(std::span<const double> values) {
  const NoiseBands bands(values);
  const auto& all = bands.ordinates;
  double frequency = 0.0, most = power_of_line;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t first = i - std::min(i, ordinates_beside), last = std::min(all.size(), i + ordinates_beside + 1);
    std::vector<double> beside;
    for (std::size_t k = first; k < last; ++k) beside.push_back(all[k].square);
    const double usual = median(beside);
    if (beside.size() <= ordinates_beside || !(usual > 0.0) || !(all[i].square > most * usual)) continue;
    most = all[i].square / usual;
    frequency = all[i].frequency;
  }
  return frequency;
}

/// The beats [fringe/s] of a segment without the sines in them, which are added to `lines`.
std::vector<double> without_dither(const Point& point, std::vector<DitherLine>& lines) {
  Sines sines(point.beats);
  for (int k = 0; k < most_dither_lines; ++k) {
    const double frequency = line_in(sines.rest());
    if (frequency == 0.0) break;
    sines.add(frequency, 2.0 / static_cast<double>(point.beats.size()));
    sines.refine();
  }
  for (const Sine& sine : sines.all()) lines.push_back({sine.frequency / point.sample_step, std::abs(sine.amplitude)});
  return {sines.rest().begin(), sines.rest().end()};
}

}  // namespace

BeatWalk beat_walk(const Sweep& sweep) {
  const auto points = usable(sweep);
  if (points.empty())
    throw Error(Error::Kind::bad_data,
                "no segment with the dither on has 64 samples or more: the random walk is not observable");
  BeatWalk walk;
  bool significant = false;
  double edf = 0.0;
  for (const Point* point : points) {
    const std::vector<double> beats = without_dither(*point, walk.lines);
    std::vector<AllanObservation> observations;
    for (const auto& allan : overlapping_allan(beats, 1.0 / point->sample_step, {}))
      observations.push_back({allan.factor, allan.deviation * allan.deviation, allan.count});
    if (std::ranges::any_of(observations, [](const auto& allan) { return !(allan.variance > 0.0); }))
      throw Error(Error::Kind::bad_data,
                  say("segment '{}': the counts do not change, as in the dead band without dither: the random "
                      "walk is not observable; say in which segments the dither runs (dither = \"off\" or "
                      "\"by_label\")",
                      point->label));
    const auto fit = fit_allan(thinned(observations), point->beats.size(), {});
    const auto white = std::ranges::find(fit.terms, NoiseTerm::white, [](const FittedTerm& t) { return t.unit.term; });
    const double weight = point->duration, step = point->sample_step;
    walk.seconds += weight;
    walk.observations += fit.residual.size();
    walk.upper_limit += weight * white->upper_limit * step;
    if (!white->kept) continue;
    significant = true;
    walk.squared += weight * white->squared * step;
    walk.variance += std::pow(weight * white->squared_sd * step, 2);
    edf = white->degrees_of_freedom;
  }
  std::ranges::sort(walk.lines, std::greater<>(), &DitherLine::amplitude);
  walk.squared /= walk.seconds;
  walk.variance /= walk.seconds * walk.seconds;
  walk.upper_limit /= walk.seconds;
  if (significant)
    walk.degrees_of_freedom = points.size() == 1 ? edf : 2.0 * walk.squared * walk.squared / walk.variance;
  return walk;
}

}  // namespace tumble::rlg_lock_in
