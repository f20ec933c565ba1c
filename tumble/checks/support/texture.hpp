#pragma once

#include <span>

namespace tumble::support {

/// Measures of how a signal changes from one sample to the next.
struct Texture {
  double quantum = 0.0;           ///< [SI] the usual least step between unequal neighbours; 0 for a constant
  double equal_neighbours = 0.0;  ///< share of samples that equal the one before
  double repeats = 0.0;           ///< the same in noise, whatever got stuck: share of runs longer than one
  /// Neighbours differ at random and by more than the quantum. False for what is smooth (a motion, a table's encoder)
  /// and for what is too coarse to show its noise (a temperature that steps by one quantum): such a signal may well
  /// stand still for minutes, or rest at its highest value.
  bool noisy = false;
};

/// Noisy means: of at least 16 steps between unequal neighbours at least 30 % turn back (2/3 in white noise, 1/2 in a
/// random walk, next to none in a smooth signal), and their mean is at least 1.25 quanta (1.0 where the signal merely
/// toggles; white noise of one quantum has 1.5).
///
/// Given     values   [SI] missing samples (NaN) are skipped
/// Valid     a long signal is judged by 64 stretches of 1024 samples spread over it
Texture texture_of(std::span<const double> values);

}  // namespace tumble::support
