#pragma once

#include <vector>

#include "tumble/methods/dtg_centrifuge/reduce.hpp"

/// The reference gyro's own line at the table's angle over the levels: true rate, and what else may be in it.
namespace tumble::dtg_centrifuge {

/// Contents of the line beside u w_t + k w_s, u the tilt of the table's axis and k its wobble twice a turn.
struct ReferenceLine {
  enum class Cause {
    none,
    late,       ///< it turns by w T: a filter, or stamps that are late
    sensitive,  ///< it grows with the specific force
    either,     ///< both explain it alike
    beside      ///< a part has the same size at every level: a field of the arm
  };
  Cause cause = Cause::none;
  Sensitivity sensitivity;           ///< v of u w_t + k w_s + v a
  double late = 0.0, late_sd = 0.0;  ///< [s] T of (u w_t + k w_s) exp(-i w T)/(1 + d w^2)
  double droop = 0.0;                ///< [s^2] d: what a filter takes from the amplitude; 0 of late stamps
  Filter filter = {};                ///< in place of both, where a low pass explains the line better
  Complex beside;                    ///< [rad/s] b of u w_t + k w_s + b, spin axis up
};

/// The lines of the reference gyro without the lag.
std::vector<Measured> without_lag(std::vector<Measured> measured, const ReferenceLine& line);

/// One net rate in one sense cannot separate T from the part of v across u to first order: T turns the line by T w_t, which
/// makes it grow as w_t^2, as the specific force does. Only where w T is so large that its square shows are they distinguished.
ReferenceLine reference_line_of(const std::vector<Measured>& measured, const Reduction& reduction);

/// Sensitivity to specific force of one gyro, by such a regression: of the gyro under test its size is K.
Sensitivity sensitivity_of(const std::vector<Measured>& measured, const Reduction& reduction, Signal signal);

/// An error where the reference gyro feels the specific force and the gyro under test does not: their channels are exchanged.
void check_exchange(const ReferenceLine& line, const std::vector<Measured>& measured, const Reduction& reduction,
                    Findings& findings);

}  // namespace tumble::dtg_centrifuge
