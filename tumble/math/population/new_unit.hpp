#pragma once

#include <span>

#include "tumble/math/population/spread.hpp"

namespace tumble {

/// A new unit as its population and its own test show it together.
struct UnitInPopulation {
  double value = 0.0, sd = 0.0;     ///< [u]
  double lower = 0.0, upper = 0.0;  ///< [u], 95 %
  double spread = 0.0;              ///< [u], mean of tau given the data of all units and of this one
  double belongs = 0.0;             ///< p-value [1], two-sided, of this result if the unit is of the population (8.16)
};

/// The estimate of a unit whose model's other units are known: empirical Bayes with what is not known of mean and
/// spread averaged over (8.14), not with their estimates put in. Of the units of the population 95 % hold their truth;
/// a unit far from the mean is held less often, as the chapter tabulates.
///
/// Given:    units [n], n >= 5, each with its private uncertainty; `unit` with the private uncertainty of its own test
///           [u], > 0.
/// Throws:   Error::bad_data for fewer than five units, and as spread_of_units().
/// Accuracy: integral over tau by 64 Gauss-Legendre nodes; 24 give the same six digits.
/// See:      docs/equations (8.13), (8.14), (8.16).
UnitInPopulation unit_in_population(std::span<const UnitValue> units, const UnitValue& unit);

}  // namespace tumble
