#pragma once

#include <vector>

#include "tumble/math/regression/mixed_model.hpp"
#include "tumble/methods/north_finding/bench.hpp"
#include "tumble/reduce/linear/linear.hpp"

namespace tumble::north_finding {

/// Noise of one signal.
struct Noise {
  double white = 0.0;           ///< s^2 [SI of the channel, squared, times s]
  double scatter = 0.0;         ///< as white, by the scatter of the rows: of a turn with the rounding to whole pulses
  std::vector<SlowNoise> slow;  ///< of its positions, with their variances
  bool slow_known = false;      ///< from the settings or the plan's truth, at least in part
  bool slow_shown = true;       ///< false: too few positions to show it
  Matrix component_covariance;  ///< of (s^2, variances of `slow`); empty where they are known
};

/// Directions of the circle that the index angles of a signal show.
struct Shown {
  bool none = true, both = false;  ///< directions in the base: none, one or both
  double along = 0.0;              ///< [rad] the one direction, from the base's x towards its y
  bool drift = false;              ///< a linear drift can be distinguished as well
};
Shown shown_by(const Signal& signal);

/// Straight least squares on [cos i, sin i, 1, t] as far as they are shown: horizontal parts of the field in the base,
/// in units of the output, and the residuals of the rows.
struct Harmonics {
  double x = 0.0, y = 0.0;  ///< of the field along x and y of the base, or `x` along Shown::along alone
  double offset = 0.0;
  std::vector<double> residuals;
  double condition = 1.0;
};
/// Given: outputs [unit of the output], one a row. `drift`: t is one of the columns.
Harmonics harmonics_of(const Signal& signal, const std::vector<double>& outputs, const Shown& shown, bool drift);

/// Estimated from the scatter within and between positions, at `state` and with the errors of the rig.
Noise noise_of(const Bench& bench, std::size_t signal, const State& state, const std::vector<Disturbance>& disturbances,
               bool drift);
/// Noise that the truth of the plan states.
Noise expected_noise(const Bench& bench, std::size_t signal, const State& state);

/// Change of the rows of a signal by a disturbance [SI of the channel].
std::vector<double> effect_of(const Signal& signal, const std::vector<Move>& moves, const State& state);

}  // namespace tumble::north_finding
