#pragma once

#include <cstddef>
#include <limits>

namespace tumble {

/// Statistics of a block of samples that can be joined with those of another. Values are less an offset that the blocks
/// of a channel share, so that a small scatter about a large mean loses no digits.
struct Moments {
  double count = 0.0;                                         ///< samples that are not missing [1]
  double mean = 0.0;                                          ///< less the offset [u]
  double squares = 0.0;                                       ///< sum of (value - mean)^2 [u^2]
  double mean_time = 0.0;                                     ///< of the samples that are not missing [t]
  double squares_time = 0.0;                                  ///< sum of (time - mean_time)^2 [t^2]
  double products = 0.0;                                      ///< sum of (value - mean)(time - mean_time) [u t]
  double minimum = std::numeric_limits<double>::infinity();   ///< [u], with the offset
  double maximum = -std::numeric_limits<double>::infinity();  ///< [u], with the offset
};

/// Moments of two blocks together.
///
/// See  T. F. Chan, G. H. Golub and R. J. LeVeque, Technical Report STAN-CS-79-773 (1979), equation 2.1
Moments joined(const Moments& a, const Moments& b);

/// Moments of `count` samples.
///
/// Given     values      [u], NaN: missing
///           times       of the samples [t]; null: first_time, first_time + 1, ...
///           first_time  [t]
///           offset      subtracted from the values [u]
Moments moments_of(const double* values, const double* times, std::size_t count, double first_time, double offset);

/// Samples between whose least and greatest a bar is drawn, and of a block that moments_of_block() takes.
constexpr std::size_t bar_samples = 64, block_samples = 1024;

/// Least and greatest of the bars of one block [u].
struct BarBounds {
  double least[block_samples / bar_samples], greatest[block_samples / bar_samples];
};

/// As moments_of(), of one block of evenly sampled values none of which is missing, with the bounds of its bars, in one
/// reading of memory: values [u], first_time [t], offset [u]. False: some are missing or infinite, and nothing was
/// calculated.
bool moments_of_block(const double* values, double first_time, double offset, Moments& moments, BarBounds& bars);

}  // namespace tumble
