#pragma once

#include <vector>

#include "tumble/reduce/linear/courses.hpp"
#include "tumble/reduce/linear/work.hpp"

/// Terms that are seen within the segments: a step or a wave that the averages of a segment follow.
namespace tumble::linear {

/// A step inside a segment.
struct StepWithin {
  std::vector<double> column;  ///< 1 of a row of the same power-up that is not before it, else 0
  std::size_t segment = 0;
  double tries = 0.0;  ///< [1] places that were tried; 0: none
};

/// Where two averages and more on either side, of a segment in which the input stays the same, differ most. Given: left [SI],
/// what the fit leaves of each row.
StepWithin step_within(const Work& work, const std::vector<double>& left);

/// A wave in time.
struct WaveWithin {
  std::vector<double> column;  ///< of each row [1]
  double period = 0.0;         ///< [s]
  double tries = 0.0;          ///< [1] waves that were tried; 0: none
};

/// The sine in time that explains most of the averages about the means of their segments, from half a wave over the test to
/// one in two segments of usual length; the level of each segment is left free. Given: left [SI].
WaveWithin wave_within(const Work& work, const std::vector<Course>& courses, const std::vector<double>& left);

}  // namespace tumble::linear
