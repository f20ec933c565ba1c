#pragma once

#include <string>

#include "tumble/core/limit.hpp"

namespace tumble {

/// The value of a bound [its unit] as it was written: the shortest decimal that is the same in SI.
double written_value(const Bound& bound);
/// "0.02 deg/h": the value as it was written, and its unit where that is not 1.
std::string bound_text(const Bound& bound);
/// "<= 0.02 deg/h", ">= 1 g", "1 g to 2 g".
std::string limit_text(const Limit& limit);
/// With the printed signs: "≤ 0.02 deg/h".
std::string limit_in_characters(const Limit& limit);

}  // namespace tumble
