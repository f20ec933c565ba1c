#pragma once

#include <vector>

#include "tumble/archive/statistics/occasions.hpp"
#include "tumble/math/population/drift.hpp"

/// Drift of a unit as the other units of its model show it.
namespace tumble::statistics {

struct FleetDrift {
  WalkDensity walks;                 ///< [u/sqrt(s)]
  double day_sd = 0.0;               ///< [u], from day to day beyond the stated uncertainties
  bool day_known = false;            ///< whether the archive has days that are close enough to see it
  double rate = 0.0, rate_sd = 0.0;  ///< [u/s], of the trends; infinite: too few units
  std::size_t units = 0;             ///< with two days or more
};

/// Visits of one unit [s since `origin`], and the errors that they share.
UnitHistory history_of(const std::vector<Occasion>& occasions, double origin, double day_sd,
                       const SharedBySource& errors);

/// From occasions [u] of all units; the history of a unit begins anew with each adjustment. At most 60 histories are
/// taken. Throws Error::bad_data where no unit has two days.
FleetDrift drift_of_fleet(const std::vector<Occasion>& occasions, const Adjustments& adjustments,
                          const SharedBySource& errors);

}  // namespace tumble::statistics
