#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/methods/random_vibration/measure.hpp"
#include "tumble/methods/random_vibration/statistics.hpp"

namespace tumble::random_vibration {

/// Table `units`: one row for each unit and vibration.
Table units_table(const std::vector<Exposure>& exposures, const vibration::Data& data, const std::vector<Type>& types,
                  const Estimate& estimate);

/// e_j of each unit: all windows, or of many the lowest and highest of each stretch.
std::vector<Curve> error_curves(const Exposure& exposure, const vibration::Data& data);

/// Findings on faults of one vibration, and on the meaning of its numbers.
/// `estimate` holds the parameters of the vibration.
void report_faults(const Exposure& exposure, const vibration::Data& data, const Estimate& estimate, Findings& findings);

/// Findings on rests that contradict the stated scale factors. Given: estimate with all its parameters.
void report_rests(const std::vector<Exposure>& exposures, const vibration::Data& data, Estimate& estimate);

/// A warning for each rest whose mean wanders by as much as a single window scatters: blocks of a sixteenth, about a straight
/// line.
void report_wander(const vibration::Data& data, Findings& findings);

}  // namespace tumble::random_vibration
