#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/fog_thermal_bias/data.hpp"

namespace tumble::fog_thermal_bias {

/// The calibrated range: the region of (T, gradient, rate, start temperature) that the fitted runs covered, bounded by
/// planes in 49 directions of the first three and by the ends of the start temperature. It is convex and holds the
/// convex hull; a point outside of it is outside of the hull.
std::vector<Covered> covered(const std::vector<RunData>& runs);

/// Whether a point lies in the range, widened by two per cent of each width.
class InRange {
 public:
  explicit InRange(std::vector<Covered> covered);
  bool operator()(const Felt& felt) const;

 private:
  std::vector<Covered> slabs_;
};

}  // namespace tumble::fog_thermal_bias
