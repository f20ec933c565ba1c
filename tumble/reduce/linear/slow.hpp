#pragma once

#include <vector>

#include "tumble/math/matrix.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/math/regression/mixed_model.hpp"

/// Slow noise of the means over segments.
namespace tumble::linear {

/// Line of the budget for noise that shifts the mean of a segment.
inline constexpr const char* drift_source = "drift between positions";

/// Name of that line in the budget where the user has stated it.
inline constexpr const char* stated_source = "bias instability, as stated";

/// When a segment's mean was taken: power-up, and from when to when since then [s].
struct Interval {
  std::size_t power_up = 0;
  double begin = 0.0, length = 0.0;
};

/// Slow noise whose variances the likelihood estimates: shifts independent from segment to segment; where there are
/// segments enough flicker, whose slowest part moves the whole test; and with several power-ups a bias of each.
///
/// Given     bias_instability   B [u], known beforehand: so much flicker is there however few segments there are, and
///                              the rest is what they show beyond. 0: not known
std::vector<SlowNoise> unknown_slow_noise(const std::vector<Interval>& intervals, std::size_t parameters, double step,
                                          double bias_instability = 0.0);

/// Slow noise of a noise model: the covariance of the means without the white noise, in the same lines of the budget.
///
///   random walk   K^2 (t_a + T_a/2) for a before b, K^2 (t_a + T_a/3) for one interval with itself
///   Markov        sd^2 (T_c^2/(T_a T_b)) exp(-gap/T_c) (1 - exp(-T_a/T_c))(1 - exp(-T_b/T_c)),
///                 2 sd^2 (r - 1 + exp(-r))/r^2, r = T_a/T_c, with itself
///   flicker       the same for the bank of Markov processes that represents it
///   quantization  2 Q^2/T_a^2 with itself
///
/// Given     intervals   must not overlap within a power-up
///           step        [s] between samples: the fastest flicker
std::vector<SlowNoise> known_slow_noise(const std::vector<Interval>& intervals, const NoiseModel& noise,
                                        double turn_on_sd, double step);

}  // namespace tumble::linear
