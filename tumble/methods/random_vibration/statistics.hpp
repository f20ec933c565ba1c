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

/// A number taken from the vibration, and how it depends on everything uncertain.
struct Statistic {
  Parameter parameter;
  /// Change of the value by each window, except for a constant: its (faded) mean is the error of the value. Empty: the
  /// value is a range, see `ranges`.
  std::vector<double> influence;
  bool faded = false;                   ///< mean of windows that fade in and out; else all have equal weight
  double expected_white = -1.0;         ///< density of `influence` at zero by rest and rectification; < 0: none
  double expected_freedom = 1.0;        ///< degrees of freedom of it
  std::vector<double> ranges;           ///< highest less lowest of each block
  double shrinking = 1.0;               ///< sd of the range of all windows over that of a block
  std::map<std::size_t, double> rest;   ///< by unit: derivative by the mean at rest
  double level = 0.0;                   ///< derivative by the logarithm of the vibration's amplitude over the plan's
  double gain = 0.0;                    ///< derivative by the logarithm of the reference's gain
  std::map<std::size_t, double> scale;  ///< by unit: derivative by the logarithm of its scale factor
};

/// All statistics of one vibration. [SI], of pulses where they are counted.
std::vector<Statistic> statistics_of(const Exposure& exposure, const vibration::Data& data,
                                     const std::vector<Type>& types, Findings& findings);

/// Parameters, covariance and budget of statistics of one vibration, appended. Errors that all vibrations of a test
/// share (level, gain of the reference, scale factors) give the covariance with those of earlier vibrations.
void append(const Exposure& exposure, const vibration::Data& data, const std::vector<Statistic>& statistics,
            Estimate& estimate);

/// K_2 and K_3 of each unit that was vibrated in positions whose a_0 differ by more than 1 g, from the rectification
/// K_2 + 3 K_3 a_0 in each.
void append_orders(const std::vector<Exposure>& exposures, const vibration::Data& data, Estimate& estimate);

/// Errors that vibrations share within the test have no key for other results.
void forget_shared(Estimate& estimate);

}  // namespace tumble::random_vibration
