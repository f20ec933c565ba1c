#pragma once

#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/models/model.hpp"

namespace tumble::prediction {

/// What would show the terms that a schedule does not.
struct Advice {
  std::vector<std::string> add;           ///< motions of the rig, each in words, the most telling first
  std::vector<std::string> out_of_reach;  ///< terms of which nothing that the rig can do tells some combination
};

/// Which candidate motions raise the rank of the schedule most, one after the other, until all terms are told apart or
/// nothing helps. Tried first: the axes and kinds of motion of the plan, with the terms that only they excite; then all
/// that the rig has.
///
/// Given     felt         what the plan's schedule feels, see felt_over()
///           terms        that it excites
///           not_excited  the others
Advice advise(const Plan& plan, const std::vector<Felt>& felt, std::vector<Term> terms,
              const std::vector<Term>& not_excited);

}  // namespace tumble::prediction
