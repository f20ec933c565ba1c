#pragma once

#include <map>
#include <string>
#include <string_view>

#include "tumble/core/plan.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {

/// `until = "sd(bias) <= 0.002 deg/h"` of a segment: it ends when the estimate so far is this good, not before
/// `at_least` and not after its duration.
struct StoppingRule {
  std::string text;
  std::string parameter;  ///< of the result of the plan's method
  double sd = 0.0;        ///< [SI]
  double at_least = 0.0;  ///< [s] of recording before which nobody looks
  Unit unit = {};         ///< of `sd` as written

  bool operator==(const StoppingRule& other) const { return text == other.text && at_least == other.at_least; }
};

/// Reads such a rule. Given: at_least [s]. Throws Error::bad_input with what would be accepted.
StoppingRule parse_stopping_rule(std::string_view text, double at_least);

/// The rules of a plan by the label of their segments. Its schedule does not hold them, because they are for the
/// station alone.
/// Throws Error::bad_input where segments of one label have different rules.
std::map<std::string, StoppingRule> stopping_rules(const Plan& plan);

}  // namespace tumble
