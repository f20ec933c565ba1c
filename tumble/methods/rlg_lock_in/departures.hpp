#pragma once

#include "tumble/methods/rlg_lock_in/dead_band.hpp"

namespace tumble::rlg_lock_in {

/// Whether the sweep needs more than K, b and W_L: scale factors or lock-in rates of the two senses that differ, a bias
/// that steps or drifts along the sweep. Each is a column beside the fit; the most significant one is said.
struct SweepDepartures {
  Findings findings;
  /// By which the fit of (1/K, b, W_L) moves if it contains what seems to be there, though it is too small to be said
  /// [SI]; empty: nothing seems to be.
  std::vector<double> shift;
};
SweepDepartures departures_of(const Sweep& sweep, const DeadBandOptions& options, const DeadBand& band);

}  // namespace tumble::rlg_lock_in
