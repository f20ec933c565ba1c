#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble::frequency_response {

/// A response measured at some frequencies, in the form its models are linear in: ln H = ln gain + i phase.
struct Measured {
  std::vector<double> frequency;        ///< [Hz], ascending, n
  std::vector<double> log_gain, phase;  ///< [1], [rad] unwrapped
  std::vector<double> log_gain_variance, phase_variance;
  double degrees_of_freedom = INFINITY;  ///< of these variances, harmonic mean
  double turn = 0.0;          ///< [rad] 0, or pi of an output that goes against the reference: `phase` is less by it
  bool turn_unknown = false;  ///< one frequency, and a phase that is either of the wrong sign or a delay
};

/// ln H(f) = ln K - i 2 pi f tau - ln D(f):  D = 1 (delay), 1 + i f/f_c (first order),
/// 1 - (f/f_n)^2 + 2 i zeta f/f_n (second order).
enum class LoopKind { delay, first_order, second_order };
const char* name(LoopKind kind);

struct LoopFit {
  LoopKind kind = LoopKind::delay;
  std::vector<double> theta;  ///< ln K, tau [s], then ln f_c or ln f_n, zeta
  Matrix gain;                ///< d theta / d (log_gain 1..n, phase 1..n)
  double chi_square = 0.0, degrees_of_freedom = 0.0, aicc = 0.0;
  bool converged = false;
  bool accepted = false;  ///< chi-square below its 99.99 % quantile
};

/// Weighted least squares in ln gain and phase, by Gauss-Newton from a grid of starts. Not converged where there are
/// fewer points than parameters or the data want a pole at zero or infinity.
LoopFit fit_loop(const Measured& measured, LoopKind kind);

/// The fits of all kinds for which there are enough points.
std::vector<LoopFit> fits_of(const Measured& measured);

/// A point that departs from the response that all the others follow.
struct Apart {
  std::size_t point = 0;  ///< index of its frequency
  double gain = 0.0;      ///< its gain over that of the response [1]
  double phase = 0.0;     ///< its phase above that of the response [rad]
};
/// Where no model is accepted: the one point without which a model is, by at least two points more than its parameters.
/// Absent: none, or more than the points can show.
std::optional<Apart> point_apart(const Measured& measured);

/// The -3 dB frequency of the fit, against its own gain at rest [Hz], with gradient over theta.
struct Derived {
  double value = 0.0;
  std::vector<double> gradient;
};
Derived bandwidth_of(const LoopFit& fit);
Derived peaking_of(const LoopFit& fit);              ///< highest gain over gain at rest; zeta < 1/sqrt(2)
Derived resonance_frequency_of(const LoopFit& fit);  ///< [Hz]
Derived delay_of(const LoopFit& fit);                ///< tau [s]
/// Delay of slow motion [s]: -d(phase)/d(omega) at 0 Hz, the lag of the loop in it.
Derived group_delay_of(const LoopFit& fit);

/// First crossing of 1/sqrt(2) of the gain at the lowest frequency, by a monotone cubic in ln f through the
/// points about it. `interpolation_sd`: difference to a straight line, over sqrt(3).
struct Crossing {
  bool found = false;
  double frequency = 0.0;
  double interpolation_sd = 0.0;
};
/// Given: frequency [Hz], ascending; log_gain, ln of the gain [1].
Crossing crossing_of(const std::vector<double>& frequency, const std::vector<double>& log_gain);

}  // namespace tumble::frequency_response
