#include "tumble/methods/rlg_lock_in/random_walk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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
    std::vector<AllanObservation> observations;
    for (const auto& allan : overlapping_allan(point->beats, 1.0 / point->sample_step, {}))
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
  walk.squared /= walk.seconds;
  walk.variance /= walk.seconds * walk.seconds;
  walk.upper_limit /= walk.seconds;
  if (significant)
    walk.degrees_of_freedom = points.size() == 1 ? edf : 2.0 * walk.squared * walk.squared / walk.variance;
  return walk;
}

}  // namespace tumble::rlg_lock_in
