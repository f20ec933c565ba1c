#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/math/matrix.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {

/// A value of one power-up: its bias, or what a model does not explain of it.
struct PowerUpValue {
  std::string label;
  double value = 0.0;     ///< [u]
  double variance = 0.0;  ///< [u^2] that noise within the power-up gives it: its scatter cannot be less
};

/// Whether the values change evenly from one power-up to the next, or else one of them is unlike all others: Student's
/// t of the column that says so beside the columns of `design`, with the scatter of the rest.
///
/// Given     powers  one a power-up, in the order in which they were recorded
///           design  [n x p] columns that explain them otherwise; a constant is one
///           unit    in which the change is shown
/// Returned  a warning, or nothing
Findings uneven_power_ups(const std::vector<PowerUpValue>& powers, const Matrix& design, const Unit& unit);

/// The power-up that may not belong to the others: Student's t of it has p below 5 % among all. The scatter of a normal
/// population is then one with it, or one without it.
///
/// Given     powers  [u]; design [n x p] as above
/// Returned  its index in `powers`
std::optional<std::size_t> doubtful_power_up(const std::vector<PowerUpValue>& powers, const Matrix& design);

}  // namespace tumble
