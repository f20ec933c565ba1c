#pragma once

#include <span>

namespace tumble {

/// The steps of an output, and what of a sample its neighbours do not predict.
struct Grain {
  double step = 0.0;      ///< [u] of which the changes are whole multiples; 0: they are not, or nothing changes
  double scatter = 0.0;   ///< [u] rms of what neighbours do not predict, rounding included
  double smallest = 0.0;  ///< [u] one change in 50 is smaller
};

/// A sample is predicted from the two before and the two after it, by weights that fit a block of samples best: a tone
/// is predicted whole, however few samples its period has, and white noise not at all. The scatter is the median over
/// the blocks, as that of white noise.
///
/// Given     values   [u] missing samples (NaN) are skipped
/// Valid     a long signal is judged by 256 blocks of 64 samples spread over it
Grain grain_of(std::span<const double> values);

/// Whether the steps are so much greater than the noise that rounding moves means: by 1 % of a step and more, however
/// many samples they have, where the noise is less than 0.4 steps (Widrow and Kollar, Quantization Noise, chapter 4).
bool is_coarse(const Grain& grain);

}  // namespace tumble
