#pragma once

#include <cstdint>
#include <vector>

#include "tumble/tasks/prediction/candidates.hpp"

namespace tumble::optimisation {

/// The visits in the order in which they are to be made.
///
/// Where the instrument drifts (`randomised`), at random, so that the drift is not taken for a term: of 64 orders drawn
/// with the seed the one with the shortest moves. Else in the order of shortest moves that nearest neighbours and the
/// exchange of two legs find. Visits with one mounting of the instrument stay together.
std::vector<prediction::CandidateVisit> ordered(const Plan& plan, const std::vector<prediction::Candidate>& all,
                                                std::vector<prediction::CandidateVisit> visits, bool randomised,
                                                std::uint64_t seed);

}  // namespace tumble::optimisation
