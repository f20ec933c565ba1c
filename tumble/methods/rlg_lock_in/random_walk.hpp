#pragma once

#include <vector>

#include "tumble/methods/rlg_lock_in/sweep.hpp"

namespace tumble::rlg_lock_in {

/// A sine in the beat: what the sampling leaves of the dither.
struct DitherLine {
  double frequency = 0.0;  ///< [Hz]
  double amplitude = 0.0;  ///< [fringe/s]
};

/// White noise of the beat in the segments with dither.
struct BeatWalk {
  double squared = 0.0;             ///< (K N)^2 [fringe^2/s]; 0: not significant
  double variance = 0.0;            ///< of `squared`
  double degrees_of_freedom = 0.0;  ///< of its root
  double upper_limit = 0.0;         ///< of `squared`, 95 %, where it is not significant
  double seconds = 0.0;             ///< of all segments used
  std::size_t observations = 0;     ///< Allan variances fitted
  std::vector<DitherLine> lines;    ///< subtracted, the strongest first
};

/// From the Allan variances of each dithered segment, those at rest where there are such (the rate of a table is not
/// even); the slopes distinguish the quantisation of the count, flicker and random walk of the rate. Sines that stand out
/// of the noise beside them are subtracted first: the dither itself, where the sampling does not hold whole periods.
///
/// Throws  Error::bad_data where no dithered segment has 64 samples
BeatWalk beat_walk(const Sweep& sweep);

}  // namespace tumble::rlg_lock_in
