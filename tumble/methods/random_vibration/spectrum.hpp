#pragma once

#include "tumble/math/shaped_noise.hpp"

/// Predictions from the density of a random vibration, for one-sided densities and Gaussian motion.
namespace tumble::random_vibration {

/// Variance of the means over windows of H [s]: INT S sinc^2(f H) df, docs/equations (3.13). Accuracy 1e-6.
double window_variance(const SpectralDensity& psd, double window);

/// Variance of the velocity [(m/s)^2]: INT S/(2 pi f)^2 df. A plain mean over T keeps sqrt(2) of its standard deviation
/// over T, for a flat density above f_0  sqrt(S/(2 pi^2 T^2 f_0)),  docs/equations (3.13).
double velocity_variance(const SpectralDensity& psd);

/// Two-sided density of the squared acceleration at zero frequency [(m/s^2)^4/Hz], INT S^2 df: the mean square over T
/// scatters by sqrt(INT S^2 df/T).
double density_of_square(const SpectralDensity& psd);

/// Mean and standard deviation of the greatest of n independent standard normal numbers.
struct Extreme {
  double mean = 0.0, sd = 0.0;  ///< [1]
};
/// Given: n [1], need not be whole.
Extreme greatest_of(double n);

/// Effect of a unit that shows no more than +-range on a normal specific force of mean a_0 and standard deviation rms.
struct Clipping {
  double share = 0.0;  ///< of the time
  double shift = 0.0;  ///< of the mean [as a_0]
};
/// Given: a_0, rms, range [one unit].
Clipping clipping(double a_0, double rms, double range);

}  // namespace tumble::random_vibration
