#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/text.hpp"

namespace tumble {

/// How a value and what belongs to it (sd, interval) are written so that they can be compared digit by digit.
struct Rounding {
  int place = 0;     ///< power of ten of the last digit shown
  int exponent = 0;  ///< power of ten taken out; 0: plain decimals
  bool significant =
      true;  ///< false: no sd to round by, or more digits than a double has; six digits are shown instead
};

/// The rounding of a value by its sd, both [unit shown]: two significant digits of sd decide.
Rounding rounding_for(double value, double sd);

/// `value` [unit shown] at that rounding, the exponent not written: "6.660". Never "-0".
std::string mantissa(double value, const Rounding& rounding);

/// `value` [unit shown] at that rounding with its exponent: "6.660e-5".
std::string rounded(double value, const Rounding& rounding);

/// A value [unit shown] to six significant digits (or `digits`) without padding; "unknown" for NaN, "inf" and "-inf".
std::string general(double value, int digits = 6);

/// A column of numbers [unit shown] as text of general(), lined up at the decimal point by `pad` in place of the digits
/// and `point` in place of the point that a number lacks. NaN becomes a dash.
std::vector<std::string> lined_up(const std::vector<double>& values, const std::string& pad, const std::string& point);

/// 95 % interval: value -+ t_0.975(degrees of freedom) sd. Both NaN where the sd, the value or the degrees of freedom
/// do not allow one.
///
/// See JCGM 100:2008 (GUM), G.6.4
struct Interval {
  double lower, upper;  ///< [unit of the value]
};
/// Given: value and sd [u]; degrees_of_freedom [1]. Returned: limits [u].
Interval interval95(double value, double sd, double degrees_of_freedom);
/// 95 % interval of a parameter [SI]: its own where it has one, else by its sd.
Interval interval95(const Estimate& estimate, std::size_t index);

/// Value and sd of a parameter in its displayed unit.
struct ShownParameter {
  double value, sd;
};
ShownParameter shown(const Estimate& estimate, std::size_t index);

/// "[6.638, 6.682]" at the rounding of value and sd, or a dash without an interval.
std::string interval_text(const Estimate& estimate, std::size_t index);

/// "6.660 ± 0.011 deg/h" of the parameter of that name, in Chinese "6.660 deg/h，u = 0.011 deg/h"; empty for an unknown
/// name.
std::string measured_text(const Estimate& estimate, std::string_view name, Language language = Language::english);

/// The two halves of with_uncertainty(), each with its exponent: "6.660e-5", "0.011e-5"; the second empty where the
/// value is not known. [unit shown]
struct ValueAndSd {
  std::string value, sd;
};
ValueAndSd value_and_sd(double value, double sd);  ///< [unit shown]

/// Part of a source in the standard uncertainty of a parameter: its sd in the displayed unit at the rounding of the
/// whole sd, and its share of the variance ("43 %", in Chinese "43%", "<1 %", a dash where the variance is not known).
struct BudgetCell {
  std::string sd, share;
};
BudgetCell budget_cell(const Estimate& estimate, const Contribution& part, std::size_t index,
                       Language language = Language::english);

/// The budget with all sources that give every parameter less than 1 % of its variance in one line. The result file
/// has each of them.
std::vector<Contribution> budget_to_show(const Estimate& estimate, Language language = Language::english);

}  // namespace tumble
