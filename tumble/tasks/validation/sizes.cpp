#include "tumble/tasks/validation/sizes.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/tasks/departed.hpp"
#include "tumble/tasks/validation/trying.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble::validation {
namespace {

/// The greatest size tried, in sizes that the budget covers [1]: reality that is further from a plan is another test.
constexpr double most_covered = 100.0;
/// The smallest size tried, in sizes that the budget covers [1].
constexpr double least_covered = 1e-4;
/// Beyond this shift [sd] no greater size is tried: the result is wrong anyhow.
constexpr double most_shift = 100.0;
/// A shift [sd] up to this is taken for proportional to the size, down to one sd.
constexpr double near_one = 1.3;
/// From one size to the next [1] where nothing says how far to go.
constexpr double great_step = 30.0, step = 3.1622776601683795;
constexpr int most_steps = 8;
/// The size that is named is known to this factor [1].
constexpr double named_within = 1.5;

/// A size, and the shift [sd] there; infinite where there is no result.
struct Sized {
  double size = 0.0, shift = 0.0;
};

/// Where the shift passes one sd: below it does not, above it does, or there is no result.
struct Bracket {
  std::optional<Sized> below, above;
  bool above_is_possible = true;  ///< the rig can do what is asked of it there
};

/// The next size to try. Between the ends by the logarithms of the shifts, else as if the shift were proportional to the size.
double next_size(const Bracket& bracket) {
  if (bracket.below && bracket.above) {
    const double ratio = bracket.above->size / bracket.below->size;
    const bool known = bracket.below->shift > 0.0 && std::isfinite(bracket.above->shift);
    if (!known) return bracket.below->size * std::sqrt(ratio);
    const double slope = std::log(ratio) / std::log(bracket.above->shift / bracket.below->shift);
    const double aimed = 1.1;  // [sd] a little above one, so that the bracket closes from above
    return bracket.below->size * std::pow(aimed / bracket.below->shift, slope);
  }
  if (bracket.below) {
    const double factor = 1.1 / std::max(bracket.below->shift, 1.0 / great_step);
    return bracket.below->size * std::clamp(factor, 1.5, great_step);
  }
  const double factor = std::isfinite(bracket.above->shift) ? bracket.above->shift / 1.1 : great_step;
  return bracket.above->size / std::clamp(factor, 1.5, great_step);
}

bool closed(const Bracket& bracket) {
  if (!bracket.above || !bracket.below) return bracket.above && bracket.above->shift <= near_one;
  return bracket.above->shift <= near_one || bracket.above->size / bracket.below->size < 1.1;
}

/// Searches from what the budget covers for the size that moves a parameter by its sd.
Bracket bracket_of(Trying& trying, double covered) {
  Bracket bracket;
  double size = covered;
  for (int i = 0; i < most_steps && !closed(bracket); ++i) {
    const Tried one = trying.shifted(size);
    if (one.possible && !one.refused && one.shift < 1.0)
      bracket.below = {size, one.shift};
    else
      bracket.above = {size, one.possible && !one.refused ? one.shift : INFINITY},
      bracket.above_is_possible = one.possible;
    if (bracket.below && !bracket.above && bracket.below->size >= most_covered * covered) break;
    if (bracket.above && !bracket.below && bracket.above->size <= least_covered * covered) break;
    size = std::clamp(next_size(bracket), least_covered * covered, most_covered * covered);
  }
  return bracket;
}

/// What ten tests say of a size.
void take(const Tried& tried, DepartureStudy& study) {
  if (tried.named) {
    study.named = tried.size;
    study.codes = tried.codes;
    study.refused = tried.refused;
  } else {
    study.greatest = std::isnan(study.greatest) ? tried.size : std::max(study.greatest, tried.size);
    if (tried.shift >= study.shift) study.shift = tried.shift, study.parameter = tried.parameter;
    if (std::isnan(study.named)) study.codes = tried.codes;
  }
}

/// Looks for the size that is named, from the one that moves a parameter upwards.
void search_named(Trying& trying, DepartureStudy& study) {
  const double limit = std::max(most_covered * study.covered, step * study.moves);
  double size = study.moves;
  for (Tried tried = trying.whole(size); tried.possible; tried = trying.whole(size)) {
    take(tried, study);
    if (tried.named || tried.shift > most_shift || size >= limit) break;
    size = std::min(size * step, limit);
  }
  while (!std::isnan(study.named) && !std::isnan(study.greatest) && study.named / study.greatest > named_within) {
    const Tried tried = trying.whole(std::sqrt(study.named * study.greatest));
    if (!tried.possible) break;
    take(tried, study);
  }
  study.exposure = std::isnan(study.greatest) ? Exposure::named_in_time : Exposure::unnoticed;
}

/// One size alone: whether it moves a parameter, and whether it is named.
void study_size(Trying& trying, double size, DepartureStudy& study, std::optional<Sentence>& why_not) {
  const Tried tried = trying.whole(size);
  why_not = tried.why_not;
  if (!tried.possible) return;
  take(tried, study);
  study.shift = tried.shift;
  study.parameter = tried.parameter;
  const bool moved = tried.refused || tried.shift >= 1.0;
  study.exposure = tried.named ? Exposure::named_in_time : moved ? Exposure::unnoticed : Exposure::harmless;
}

void search(Trying& trying, DepartureStudy& study, std::optional<Sentence>& why_not) {
  const Bracket bracket = bracket_of(trying, study.covered);
  if (!bracket.above || (bracket.below && !bracket.above_is_possible)) {
    study.greatest = bracket.below->size;
    study.shift = bracket.below->shift;
    return;  // harmless, as far as it can be made
  }
  if (!bracket.above_is_possible) {
    why_not = trying.shifted(bracket.above->size).why_not;
    return;
  }
  const bool proportional = bracket.above->shift <= near_one;
  study.moves = proportional ? bracket.above->size / bracket.above->shift : bracket.above->size;
  study.parameter = trying.shifted(bracket.above->size).parameter;
  study.shift = 1.0;
  search_named(trying, study);
}

}  // namespace

std::vector<Cell> cells_of(const Bench& bench, const ValidateOptions& options) {
  std::vector<Cell> cells;
  const auto test = sound_test(bench, 0);
  for (const Departure& departure : departure_catalogue()) {
    if (!options.departure.empty() && options.departure != departure.name) continue;
    if (options.size && departure.covered == nullptr)
      throw Error(Error::Kind::bad_input, say("'{}' has no size: it happens or it does not", Name{departure.name}));
    const auto targets = targets_of(departure, *test);
    for (const std::string& target : targets)
      if (options.target.empty() || options.target == target) cells.push_back({&departure, target});
    if (!options.departure.empty() && cells.empty()) refuse_target(departure, targets, options.target);
  }
  return cells;
}

Studied study(const Bench& bench, const Cell& cell, const std::optional<Quantity>& only) {
  Trying trying(bench, cell);
  Studied out;
  out.study = {.departure = cell.departure,
               .target = cell.target,
               .unit = unit_of_size(*cell.departure, trying.sound(0).evidence.recordings, cell.target)};
  out.study.sized = cell.departure->covered != nullptr;
  if (out.study.sized)
    out.study.covered = cell.departure->covered(bench.plan, trying.sound(0).evidence.recordings, cell.target);
  if (!out.study.sized || only)
    study_size(trying, only ? size_in(*only, out.study.unit) : 0.0, out.study, out.why_not);
  else
    search(trying, out.study, out.why_not);
  out.tests = trying.tests();
  return out;
}

}  // namespace tumble::validation
