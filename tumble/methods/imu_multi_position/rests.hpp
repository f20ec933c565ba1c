#pragma once

#include <optional>
#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/methods/imu_multi_position/data.hpp"

namespace tumble::imu_multi_position {

struct RestOptions {
  double window = 0.5;        ///< [s] over which the variance is taken
  double least = 1.0;         ///< [s] a rest must last
  double initial_rest = 0.0;  ///< [s] at the beginning, known to be at rest: its noise is the noise level; 0: unknown
};

/// A time in which nothing moved.
struct Rest {
  std::size_t session = 0;
  double begin = 0.0, end = 0.0;  ///< [s]
  Vector3 force, rate;            ///< means [unit of the channels]
  std::size_t samples = 0, gyro_samples = 0;
  std::optional<Finding> rejection;  ///< why it is not used
  bool used() const { return !rejection; }
};

/// Variances of a sample towards zero frequency, [unit^2 s]: over the time averaged it is the variance of a mean.
struct Densities {
  Vector3 force, rate;
  double degrees_of_freedom = 0.0;
};

struct Rests {
  std::vector<Rest> all;  ///< in order of session and time
  Densities noise;
  double multiplier = 0.0;  ///< of the variance of the quietest fifth, below which it is at rest
  std::size_t tried = 0;    ///< multipliers that gave enough rests
};

/// Where the variance over a window (of accelerometers and gyros, by running sums) stays below a multiple of that of
/// the quietest fifth of the recording. The multiple is that whose rests give the sharpest calibration of the
/// accelerometers: the least log det of the covariance of the nine coefficients, scatter about |f| = `gravity`
/// included. Rests that drift, or that a bump separates from a longer one in the same pose, are rejected.
/// Given: gravity [m/s^2].
Rests find_rests(const std::vector<Session>& sessions, const RestOptions& options, double gravity);

/// Mean of the second half of a rest minus that of the first.
Vector3 drift_of(const Triad& triad, const Rest& rest);

}  // namespace tumble::imu_multi_position
