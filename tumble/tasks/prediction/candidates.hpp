#pragma once

#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/models/model.hpp"

namespace tumble::prediction {

/// One thing the rig could do for the plan: a position held, a rate, an oscillation. Every axis that the candidates
/// move is named in it, so that it stays what it is wherever it stands in a schedule.
struct Candidate {
  std::map<std::string, Motion> approach = {};  ///< held before the work begins; empty: the work itself is a hold
  std::map<std::string, Motion> work = {};
  double setup = 0.0;           ///< [s] from the neutral position until the axes have reached the motion
  double spin_up = 0.0;         ///< [s] of it after the approach
  double least = 0.0;           ///< [s] the shortest useful time in the motion: one revolution or period, 0 at rest
  double fastest = 0.0;         ///< highest frequency [Hz] in what is felt
  std::vector<Felt> felt = {};  ///< nominal: one at rest, several over `least` in motion
};

/// Axes and kinds of motion among which candidates are sought.
struct CandidateRange {
  std::vector<std::string> axes;  ///< those not named stay where the rig has them
  bool rates = false, sines = false;
  double step = 0.0;                                            ///< [rad] of the grid of positions
  bool corners = true;                                          ///< and the angles that put the corners of a cube up
  double most_rate = std::numeric_limits<double>::infinity();   ///< [rad/s] that the instrument may feel
  double most_force = std::numeric_limits<double>::infinity();  ///< [m/s^2]
};

/// The axes that the plan's schedule moves, and the kinds of motion in it. Given: step of the positions [rad].
CandidateRange range_of(const Plan& plan, double step);

/// Sets what the instrument may feel: 0.9 of the `range` of its [truth], else the most that the plan's own schedule
/// gives, since nothing else says what it bears.
void limit_to_instrument(const Plan& plan, CandidateRange& range);

/// Positions on the grid, rates of both senses at several levels up to the rig's highest, oscillations of several
/// frequencies: all that the rig does not refuse, each felt once. Linear and thermal axes take five levels over what
/// the rig accepts between the extremes of the plan.
std::vector<Candidate> candidates(const Plan& plan, const CandidateRange& range);

/// Motions that the instrument feels in all candidates, one after the other.
std::vector<Felt> felt_of(const std::vector<Candidate>& all);

struct CandidateVisit {
  std::size_t candidate = 0;
  double dwell = 0.0;  ///< [s] in the motion
};

/// The schedule of one power-up that visits candidates in this order. Every segment lasts as long as the rig needs for
/// the move, then `settling` [s] and the dwell, in whole samples.
Schedule schedule_of(const Plan& plan, const std::vector<Candidate>& all, const std::vector<CandidateVisit>& visits,
                     double settling);

/// "outer 45 deg, inner -90 deg", "outer 10 deg/s": only what is not at rest at zero, or "all axes at zero".
std::string in_words(const std::map<std::string, Motion>& axes, const Plan& plan);

}  // namespace tumble::prediction
