#pragma once

#include <string>
#include <string_view>

#include "tumble/units/unit.hpp"

/// Numbers, units and symbols as HTML, for pages that are written outside of this module.
namespace tumble {

/// A number text of rounding.hpp with a true minus sign and its exponent as a power: "6.66 × 10⁻⁵".
std::string typeset_number(std::string_view text);
/// A number text in characters alone: "(−0.5 ± 1.2) × 10⁻⁶".
std::string number_in_characters(std::string_view text);
/// "deg/h^2" with the exponent raised; "1" is empty.
std::string typeset_unit(const Unit& unit);
/// "K_1" with the index below.
std::string typeset_symbol(std::string_view text);

}  // namespace tumble
