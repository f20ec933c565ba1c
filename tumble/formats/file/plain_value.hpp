#pragma once

#include "tumble/units/unit.hpp"

namespace tumble::file {

/// `value_si` [SI] in `unit` as a file holds it: of the doubles that convert back to exactly `value_si`, the one whose
/// decimal is the shortest, so that what a file said is written again. Where no double converts back (some numbers are
/// not the product of any double and the factor), the nearest.
double plain_value(double value_si, const Unit& unit);

}  // namespace tumble::file
