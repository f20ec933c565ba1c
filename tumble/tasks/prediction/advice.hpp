#pragma once

#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/models/model.hpp"

namespace tumble::prediction {

/// Motions that would show the terms which a schedule does not show.
struct Advice {
  std::vector<std::string> add;           ///< motions of the rig, each in words, the most useful first
  std::vector<std::string> out_of_reach;  ///< terms of which no motion of the rig determines some combination
};

/// Candidate motions that raise the rank of the schedule most, one after the other, until the schedule distinguishes
/// all terms or no motion helps. Tried first: the axes and kinds of motion of the plan, with the terms that only they
/// excite; then all that the rig has.
///
/// Given     felt         what the plan's schedule feels, see felt_over()
///           terms        that it excites
///           not_excited  the others
Advice advise(const Plan& plan, const std::vector<Felt>& felt, std::vector<Term> terms,
              const std::vector<Term>& not_excited);

}  // namespace tumble::prediction
