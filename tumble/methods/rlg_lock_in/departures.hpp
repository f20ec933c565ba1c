#pragma once

#include "tumble/methods/rlg_lock_in/dead_band.hpp"

namespace tumble::rlg_lock_in {

/// Whether the sweep needs more than K, b and W_L: scale factors or lock-in rates of the two senses that differ, a bias
/// that steps or drifts along the sweep. Each is a column beside the fit; the most significant one is said.
Findings departures_of(const Sweep& sweep, const DeadBandOptions& options, const DeadBand& band);

}  // namespace tumble::rlg_lock_in
