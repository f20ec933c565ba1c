#pragma once

#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/methods/frequency_response/loop.hpp"
#include "tumble/methods/frequency_response/point.hpp"

namespace tumble::frequency_response {

/// ln H of the points, with phases that continue without jumps from 0 Hz on. An output that goes against the reference
/// has a phase of 180 deg there, a delay 0 deg: the loops are fitted to both, with as many turns at the lowest
/// frequency as may be, and the phase is that as measured (within half a turn at the lowest frequency) unless another
/// fits ten times better.
Measured measured_of(const std::vector<Point>& points);

/// An error where the output goes against the reference, and a warning where one frequency cannot distinguish that from
/// a delay. Given: relative, whether the output is of another kind and no scale factor says its sign (then a warning).
void report_sign(const Measured& measured, bool relative, Findings& findings);

/// -d(phase)/d(omega) at 0 Hz by phase = -2 pi f (tau + c_1 f^2 + c_2 f^4 + ...), with as many terms as the phases
/// need.
struct PhaseSlope {
  bool found = false;            ///< false: no polynomial of four terms holds the phases
  double delay = 0.0;            ///< [s]
  std::vector<double> gradient;  ///< [s] over (ln gain 1..n, phase 1..n)
  double model_sd = 0.0;         ///< [s] difference that one more term makes, over sqrt(3)
};
PhaseSlope slope_at_rest(const Measured& measured);

}  // namespace tumble::frequency_response
