#pragma once

/// Effect of the rounding to whole pulses on a mean.
namespace tumble::pulses {

/// Variance [pulse^2] of the part of a pulse that one reading of a counter does not show.
constexpr double reading_variance = 1.0 / 12.0;

/// Variance of the mean over `seconds` of a quantity that is `pulse` [its unit times s] for each pulse: the readings at
/// its two ends, however many windows lie between; 1/6 pulse^2 on average over the fraction of a pulse in a window
/// (3.14).
constexpr double rounding_variance(double pulse, double seconds) {
  return pulse == 0.0 ? 0.0 : 2.0 * reading_variance * pulse * pulse / (seconds * seconds);
}

}  // namespace tumble::pulses
