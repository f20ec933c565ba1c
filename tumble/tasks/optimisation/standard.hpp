#pragma once

#include <string>
#include <vector>

#include "tumble/tasks/prediction/candidates.hpp"

namespace tumble::optimisation {

/// A schedule that is usual: each of its candidates once, all for the same time.
struct StandardSet {
  std::string name;
  std::vector<std::size_t> candidates;
};

/// Usual sets, as far as the candidates hold them: specific force along the faces, edges and corners of a cube fixed to
/// the instrument, the 24 orientations of the cube, rates of each axis alone at equal steps. If several positions have
/// the same direction, the first one is taken, which is the simplest.
std::vector<StandardSet> standard_sets(const std::vector<prediction::Candidate>& all);

}  // namespace tumble::optimisation
