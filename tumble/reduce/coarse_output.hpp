#pragma once

#include <optional>
#include <vector>

#include "tumble/reduce/stretches.hpp"

namespace tumble {

/// An output whose steps are no smaller than its noise: means of many samples are still off by a part of a step.
struct CoarseOutput {
  double step = 0.0;         ///< q [u]
  double level = 0.0;        ///< [u] one of the values: the others are whole steps from it
  double noise = 0.0;        ///< s of a sample [u]
  double rounding_sd = 0.0;  ///< of a mean [u], over all places that its true value may have within a step
};

/// Error of the means of stretches at rest that rounding to steps causes:
///
///   rounding_sd^2 = sum_k q^2/(2 pi^2 k^2) exp(-4 pi^2 k^2 s^2/q^2),   k = 1, 2, ...
///
/// q^2/12 where the noise is far below a step, a thousandth of q where it is 0.54 q. The scatter about the mean of a
/// stretch shows s: its square is s^2 + q^2/12 - rounding_sd^2 on average.
///
/// The step is the greatest value of which all differences between values are whole multiples, four values at least;
/// where the rests show fewer, those of the stretches that move count too. Where no stretch shows two values, they must differ by a hundred steps and more for this to mean anything.
///
/// Returned  nothing where the noise takes more values than that, or the values have no common step
/// See       Widrow and Kollar, Quantization Noise (2008), chapter 4: the characteristic function of rounded noise
std::optional<CoarseOutput> coarse_output(const ConductedTest& test);

/// The rounding_sd [u] above, of samples that scatter by `scatter` [u], their rounding included, about what they show.
///
/// Given     step  [u] above zero
double rounding_sd(double step, double scatter);

}  // namespace tumble
