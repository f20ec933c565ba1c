#pragma once

#include <map>
#include <string>
#include <string_view>

#include "tumble/units/unit.hpp"

namespace tumble::declaration {

/// Value of one step of a number: "2^-14 deg/s", "2^-21 deg/sample".
struct Scale {
  double factor = 1.0;  ///< [unit]
  Unit unit;            ///< without "/sample"
  bool increment = false;
};

/// Scales by the names that a declaration gives them.
using Scales = std::map<std::string, std::string>;

/// In place of a scale that a variant has to say.
inline constexpr std::string_view chosen_by_variant = "by variant";

/// A product and quotient of numbers and powers, a space, and a unit; or a unit alone; or a name of `scales`.
/// Throws Error::bad_input.
Scale parse_scale(std::string_view text, const Scales& scales);

}  // namespace tumble::declaration
