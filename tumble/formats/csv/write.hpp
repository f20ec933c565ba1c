#pragma once

#include <string>

#include "tumble/units/unit.hpp"

namespace tumble::csv {

/// Appends `value_si` [SI] in `unit`: the shortest decimal that converts back to the same value. A missing sample
/// appends nothing.
void append_value(std::string& text, double value_si, const Unit& unit);

/// Appends an evenly spaced stamp [s] with as many decimals as show a millionth of the interval [s].
void append_even_time(std::string& text, double t, double interval);

}  // namespace tumble::csv
