#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/methods/sine_vibration/measure.hpp"
#include "tumble/methods/sine_vibration/rectification.hpp"

namespace tumble::sine_vibration {

/// Parameters with covariance and budget.
Estimate describe(const Evidence& evidence, const vibration::Data& data, const Measured& measured,
                  const std::vector<Rectification>& rectified);

/// Tables `response`, `units` and curves over frequency, with findings that explain them.
void add_tables(const vibration::Data& data, const Measured& measured, const std::vector<Rectification>& rectified,
                Estimate& estimate);

/// "up", "down", "level": how the input axis points. Given: rest, specific force along it at rest [m/s^2].
std::string way_name(double rest);

/// A finding where the reference shows another level than the plan, over all tones, by three standard deviations of both, unless a
/// tone has one of its own.
void compare_levels(const Evidence& evidence, const vibration::Data& data, const Measured& measured,
                    Findings& findings);

/// Findings on rests that contradict the stated scale factors. Given: estimate with its parameters.
void report_rests(const Evidence& evidence, const vibration::Data& data, const Measured& measured, Estimate& estimate);

}  // namespace tumble::sine_vibration
