#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/methods/north_finding/noise.hpp"
#include "tumble/reduce/answer.hpp"

namespace tumble::north_finding {

/// Quantities that the test estimates, and the state around which.
struct Setup {
  State start{};
  std::vector<Quantity> free;  ///< azimuth first
  Shown shown;                 ///< by the gyro
  bool drift = false;
  std::optional<double> other_azimuth;  ///< [rad] where only one direction is shown: the mirror image
  Findings findings;
};

/// From the closed forms. Throws Error::bad_data where the test does not show the azimuth.
Setup set_up(const Bench& bench, const Instrument& instrument);
/// The set-up of a prediction: around the attitude that the rig has.
Setup set_up_prediction(const Bench& bench, const Instrument& instrument);

struct Solution {
  State state{};
  std::vector<Quantity> free;
  Matrix covariance;
  std::vector<ErrorLine> lines;
  std::vector<double> degrees_of_freedom;
  Matrix gain;  ///< free quantities by rows, the rows of the signals one after the other
  Fit fit;
};

/// Generalised least squares of all channels together, the noise white within positions and slow between them, the
/// rig's errors and what is known beforehand as random effects common to the channels; Gauss-Newton about `start`.
Solution solve(const Bench& bench, const Instrument& instrument, const Setup& setup, const std::vector<Noise>& noise,
               const std::vector<Disturbance>& disturbances, bool predicted);

}  // namespace tumble::north_finding
