#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tumble/math/matrix.hpp"
#include "tumble/math/noise/noise_likelihood.hpp"
#include "tumble/math/noise_model.hpp"

namespace tumble::allan_noise {

/// Probability below which a course is no chance: 3 sigma, as of a straight trend.
constexpr double course_chance = 0.0027;

/// Averages of a record over equal times, one after the other.
struct SlowAverages {
  std::vector<double> mean;   ///< [u] NaN: nothing measured
  std::vector<double> share;  ///< measured part of each, 0 to 1
  double interval = 0.0;      ///< [s]
};

/// Averages over `stride` samples each. Given: values [u], NaN: missing; rate [Hz].
SlowAverages slow_averages(std::span<const double> values, double rate, std::size_t stride);
/// Samples in each of at most `most` averages.
std::size_t slow_stride(std::size_t samples, std::size_t most);

/// One kind of noise that the record might have, of several that are compared.
struct SlowHypothesis {
  double slow = 1.0;  ///< variance of flicker and Gauss-Markov process over that of the fit, or what it leaves possible
  double walk = 1.0;  ///< variance of the random walk over the greatest that the fit leaves possible
};

/// A known course of the bias beside the noise: columns whose sizes are estimated.
struct CourseFit {
  double fall = 0.0;          ///< of -2 ln L by the course
  std::vector<double> size;   ///< [u over the unit of the column]
  Matrix covariance;          ///< of the sizes
  SlowHypothesis hypothesis;  ///< noise that explains the record best beside the course
};

/// By how much courses explain the averages better than noise alone. Each of `courses` is tried by itself, beside a
/// constant and a straight trend, by the exact likelihood of the averages; white noise is as fitted, and flicker and
/// walk are as large as suits each hypothesis best, with the course and without it. So neither a walk that was found
/// because of the course hides it, nor one that is too weak to be found by itself is taken for it.
///
/// Given     courses  [n x c] each, values of its columns for each average
///           fit, rate   the noise found in the record, which includes the course; rate [Hz] of its samples
/// Returned  a fit each; none where the averages do not determine it
std::vector<CourseFit> fit_courses(const SlowAverages& averages, const std::vector<Matrix>& courses,
                                   const NoiseFit& fit, double rate);

/// The bands with another slow part, which differs by a known course.
/// Given: slow [u], of the length of bands.slow.
NoiseBands with_slow_part(const NoiseBands& bands, std::span<const double> slow);

/// Gives the bands back the noise that an estimated course took: the rest lacks x C x' of its covariance.
/// Given: columns [n x c] for each of the slow values; covariance [c x c] of their sizes.
void give_back_course(const Matrix& columns, const Matrix& covariance, NoiseBands& bands);

}  // namespace tumble::allan_noise
