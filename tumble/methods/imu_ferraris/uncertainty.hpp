#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/methods/imu_ferraris/sections.hpp"

namespace tumble::imu_ferraris {

/// A value, its standard uncertainty, and where it comes from.
struct Known {
  double value = 0.0, sd = 0.0;
  Phrase origin;
};

/// Gravity of the settings, of the site, or of anywhere on Earth.
Known gravity_of(const Plan& plan);

/// Alignment of the poses, from the poses themselves: outputs across the vertical, summed over the two poses of an
/// axis, would be the bias of the pose along it.
struct Squareness {
  double sd = 0.0;       ///< [rad] of each tilt of a pose; 0: no more than the noise
  double freedom = 6.0;  ///< degrees of freedom
};
Squareness squareness(const Means& means, const Calibration& calibration, const Recorded& recorded);

/// Variance [unit^2] of the mean of output k in a section, by its noise.
double variance(const Recorded& recorded, std::size_t section, std::size_t k);
/// The variance of the gyros in units of their noise [1]: as the pairs show it. A drift that they show beyond doubt is common to
/// neighbours, and the mean of the three pairs has its whole variance.
double shown_variance(const Means& means, const Recorded& recorded);

/// One cause of error: independent errors z of these standard deviations, and their effect on the means.
struct Cause {
  std::string name;
  std::vector<double> sd;
  double freedom;
  std::function<void(std::span<const double> z, Means& means)> disturb;
  bool curved = false;   ///< its square matters
  std::string key = {};  ///< of one error, see Contribution
};

/// Errors of the parameters that a cause makes.
struct Moments {
  Matrix covariance;          ///< [p x p] in SI, second moments of the errors about their mean
  std::vector<double> shift;  ///< [p] in SI, mean of the errors: not zero where the cause is curved
};

std::vector<Cause> causes(const Plan& plan, const Means& means, const Calibration& calibration,
                          const Recorded& recorded, Findings& findings);

/// Errors of the parameters by one cause, from the closed form disturbed: J S J', and where the cause is curved also
/// tr(H_a S H_b S)/2 about the mean tr(H S)/2 for normal errors, with derivatives by differences. S itself has a
/// relative standard deviation of sqrt(2/freedom), by which the mean is uncertain.
Moments moments_of(const Cause& cause, const Means& means);

/// Errors [SI] of the parameters (p) where the one error of a cause is at one standard deviation.
std::vector<double> signed_shift(const Cause& cause, const Means& means);

}  // namespace tumble::imu_ferraris
