#pragma once

#include <map>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/random_vibration/measure.hpp"

namespace tumble::random_vibration {

/// Units that are compared as one.
struct Type {
  std::string name;
  std::vector<std::size_t> units;  ///< indices of Data::units
};

/// From the setting `types`, "quartz: Q1 Q2; wire: S1 S2"; empty: each unit is its own type.
/// Throws Error::bad_input that lists names not recorded, units named twice and what cannot be read.
std::vector<Type> types_of(const std::string& text, const std::vector<vibration::UnitUnderTest>& units);

/// A number taken from the vibration, and how it hangs on everything uncertain.
struct Statistic {
  Parameter parameter;
  /// Change of the value by each window, but for a constant: the value is off by the (faded) mean of it. Empty: the
  /// value is a range, see `ranges`.
  std::vector<double> influence;
  bool faded = false;             ///< mean of windows that fade in and out; else all count alike
  double expected_white = -1.0;   ///< density of `influence` at zero that rest and rectification let expect; < 0: none
  double expected_freedom = 1.0;  ///< degrees of freedom of it
  std::vector<double> ranges;     ///< highest less lowest of each block
  double shrinking = 1.0;         ///< sd of the range of all windows over that of a block
  std::map<std::size_t, double> rest;   ///< by unit: derivative by the mean at rest
  double level = 0.0;                   ///< derivative by the logarithm of the vibration's amplitude over the plan's
  double gain = 0.0;                    ///< derivative by the logarithm of the reference's gain
  std::map<std::size_t, double> scale;  ///< by unit: derivative by the logarithm of its scale factor
};

/// All of one vibration. [SI], of pulses where they are counted.
std::vector<Statistic> statistics_of(const Exposure& exposure, const vibration::Data& data,
                                     const std::vector<Type>& types, Findings& findings);

/// Parameters, covariance and budget of statistics of one vibration, appended. What all vibrations of a test have in
/// common (level, gain of the reference, scale factors) gives the covariance with those of earlier vibrations.
void append(const Exposure& exposure, const vibration::Data& data, std::vector<Statistic> statistics,
            Estimate& estimate);

/// K_2 and K_3 of each unit that was vibrated in positions whose a_0 differ by more than 1 g, from the rectification
/// K_2 + 3 K_3 a_0 in each.
void append_orders(const std::vector<Exposure>& exposures, const vibration::Data& data, Estimate& estimate);

/// What vibrations share within the test is no key to other results.
void forget_shared(Estimate& estimate);

}  // namespace tumble::random_vibration
