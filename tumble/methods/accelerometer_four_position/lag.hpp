#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/methods/accelerometer_four_position/positions.hpp"
#include "tumble/methods/accelerometer_four_position/reduce.hpp"

namespace tumble::accelerometer_four_position {

/// Change of the output from the first to the second half of a position, with its noise and counting.
struct ChangeWithin {
  double value = 0.0, sd = 0.0;  ///< [m/s^2]
};

/// Error of the result of a unit whose temperature follows the thermometer late.
struct LateUnit {
  bool shown = false;        ///< the changes within the positions show a lag; else they do not exclude it
  double behind = 0.0;       ///< [K] of the thermometer
  std::string where;         ///< position in which the shift is most, in units of its uncertainty
  Quantity quantity = bias;  ///< or scale factor error
  double shift = 0.0;        ///< of it [SI]
};

/// With T_L the thermometer's reading behind a lag of first order, D the difference between the halves of a position
/// and dE/dT by the polynomials:
///
///   D E = dE/dT D T + d + k dE/dT (D T_L - D T)
///
/// with a drift d that all positions share. k is 1 with this lag and 0 without.
///
/// Given     changes  D E, one a position
///           lag      [s]
/// Returned  nothing where k excludes the lag by three of its sd, where the lag would shift neither bias nor scale
///           factor error by more than twice their uncertainty, or where there is no measured temperature or only one
/// See       lack_of_fit
std::optional<LateUnit> late_unit(const Bench& bench, const Reduced& reduced, const std::vector<ChangeWithin>& changes,
                                  double lag);

}  // namespace tumble::accelerometer_four_position
