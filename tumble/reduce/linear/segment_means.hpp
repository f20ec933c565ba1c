#pragma once

#include <cstddef>
#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble::linear {

struct Work;

/// The means over some segments, as a regression.
struct SegmentMeans {
  std::vector<std::size_t> segments;  ///< indices of the stretches
  Matrix design;                      ///< one row each
  std::vector<double> output;         ///< without the input [SI]
  std::vector<double> time;           ///< [s] since power-on, middle
  std::vector<double> duration;       ///< [s]
  Matrix effects;                     ///< of the known effects, one column each [SI]
  Matrix covariance;                  ///< [SI^2]
};

/// Given     work           with its fit
///           segments       indices of the stretches
///           slow_variance  [SI^2 / unit of the kernel] of each slow noise of the work's data, for the covariance
SegmentMeans segment_means(const Work& work, std::vector<std::size_t> segments,
                           const std::vector<double>& slow_variance);

}  // namespace tumble::linear
