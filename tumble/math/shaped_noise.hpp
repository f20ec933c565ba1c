#pragma once

#include <memory>
#include <span>
#include <vector>

#include "tumble/math/random.hpp"

namespace tumble {

/// A one-sided power spectral density given at some frequencies, with straight lines between them where both scales are
/// logarithmic, and nothing outside of them.
struct SpectralDensity {
  std::vector<double> frequency;  ///< [Hz], rising, > 0, two or more
  std::vector<double> density;    ///< [u^2/Hz], > 0
};

/// At frequency f [Hz]; 0 outside.
double density_at(const SpectralDensity& psd, double f);

/// Variance of a process with this density [u^2], in closed form:
///
///   sum of S_1 f_1/(p + 1) ((f_2/f_1)^(p + 1) - 1),  p = ln(S_2/S_1)/ln(f_2/f_1);  S_1 f_1 ln(f_2/f_1) for p = -1
double variance(const SpectralDensity& psd);

/// A stationary Gaussian process of a given density, as a function of continuous time that may be asked for anywhere,
/// in any order and from any thread.
///
/// White noise (numbered, so that any part of it can be made) is filtered in blocks by fast convolution, at six times
/// the highest frequency; the values are the coefficients of a spline of fifth degree, whose own frequency response the
/// filter takes back.
///
/// Valid     lines and edges of the density are smoothed over 2/T, where the filter lasts T = 16 periods of the lowest
///           frequency, or 8 over the least distance of the points, at most 131072 coefficients. The variance is exact.
/// Accuracy  above the highest frequency, images of the spline: below 1e-8 of the density
/// See       A. V. Oppenheim and R. W. Schafer, Discrete-Time Signal Processing, section 8.7 (overlap-save);
///           M. Unser, Splines: a perfect fit for signal and image processing, IEEE Signal Processing Magazine 1999,
///           eq. (2) and (5)
class ShapedNoise {
 public:
  ShapedNoise(const SpectralDensity& psd, const RandomStream& random);

  /// At first, first + step, ... [s], all >= 0.
  void values(double first, double step, std::span<double> out) const;

  /// The process and its derivatives by time.
  struct Value {
    double value, first_derivative, second_derivative;  ///< [u], [u/s], [u/s^2]
  };
  /// At a time >= 0 [s].
  Value at(double time) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

}  // namespace tumble
