#pragma once

#include <cmath>
#include <optional>
#include <string_view>

#include "tumble/units/unit.hpp"

namespace tumble {

/// One end of a limit.
struct Bound {
  double value = 0.0;  ///< [SI]
  Unit unit = {};      ///< that people are shown
};

/// The range that a plan allows for a parameter. At least one end is given.
struct Limit {
  enum class Kind { at_least, at_most, between };
  std::optional<Bound> lower = {}, upper = {};

  Kind kind() const { return lower && upper ? Kind::between : lower ? Kind::at_least : Kind::at_most; }
  /// [SI] The lower end; minus infinity where none is given.
  double lowest() const { return lower ? lower->value : -INFINITY; }
  /// [SI] The upper end; infinity where none is given.
  double highest() const { return upper ? upper->value : INFINITY; }
};

/// A bound in code: bound(0.02, "deg/h"), value [unit].
inline Bound bound(double value, std::string_view unit) { return {si(value, unit), Unit::parse(unit)}; }

}  // namespace tumble
