#pragma once

#include <array>

#include "tumble/exchange/calibration.hpp"

/// Fixed-point formats of a calibration by its ranges, and how far rounding takes the code from the formula.
namespace tumble::c_code {

inline constexpr int guard_bits = 4;    ///< of what is calculated, beyond the bits of outputs and inputs
inline constexpr int share_bits = 30;   ///< of numbers between -1 and 1
inline constexpr int kelvin_bits = 16;  ///< of temperatures

/// Formats of one triad: a number v is the integer v 2^bits.
struct TriadFormat {
  int output_bits = 0;        ///< of the outputs
  int input_bits = 0;         ///< of what the code returns
  int inverse_bits = 0;       ///< of inv(K)
  int force_bits = 0;         ///< of G
  double output_limit = 0.0;  ///< [output] greatest output of the range
  double error = 0.0;         ///< [u] greatest rounding error of the range
  /// The curve of an axis takes its input as a share of 2^curve_exponent: see curve_exponent().
  std::array<int, 3> curve_exponent{};
};

struct FixedFormat {
  TriadFormat force, rate;
  int temperature_bits = 0;  ///< d = T - T_r [K] is 2^temperature_bits times a number between -1 and 1
};

/// Bits such that every output and input of the range is below 2^29, and every sum of the code below 2^63.
///
/// Throws    Error::bad_input where that is not possible
FixedFormat fixed_format(const ImuCalibration& calibration, int force_passes, int rate_passes);

}  // namespace tumble::c_code
