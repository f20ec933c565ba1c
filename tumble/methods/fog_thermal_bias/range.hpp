#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/fog_thermal_bias/data.hpp"

namespace tumble::fog_thermal_bias {

/// The calibrated range: the region of (T, gradient, rate, start temperature) that the fitted runs covered, bounded by
/// planes in 49 directions of the first three and by the ends of the start temperature. It is convex and holds the
/// convex hull; a point outside of it is outside of the hull.
/// Rows: the weights of a direction and the lowest and highest weighted sum seen.
Table calibrated_range(const std::vector<RunData>& runs);

/// Whether a point lies in the range, widened by two per cent of each width.
class InRange {
 public:
  explicit InRange(const Table& calibrated_range);
  bool operator()(const Felt& felt) const;

 private:
  struct Slab {
    double temperature, gradient, rate, start, lower, upper;
  };
  std::vector<Slab> slabs_;
};

}  // namespace tumble::fog_thermal_bias
