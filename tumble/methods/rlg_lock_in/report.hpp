#pragma once

#include <optional>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/rlg_lock_in/dead_band.hpp"
#include "tumble/methods/rlg_lock_in/random_walk.hpp"

namespace tumble::rlg_lock_in {

/// Results of the parts of the test.
struct Answer {
  std::optional<DeadBand> band;
  std::optional<BeatWalk> walk;
  Findings findings;
  std::vector<double> shift;  ///< of (1/K, b, W_L) [SI], by what the sweep may hold beside them; empty: nothing
};

/// Parameters with their covariance and budget; the random walk beside (4.27).
Estimate estimate_of(const Answer& answer, const Settings& settings);

/// Table `sweep` and the figure of the dead band.
void append_curves(const Sweep& sweep, const DeadBand& band, Estimate& estimate);

}  // namespace tumble::rlg_lock_in
