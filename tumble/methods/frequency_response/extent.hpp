#pragma once

#include "tumble/methods/frequency_response/data.hpp"

/// The time in which the reference shows one tone.
namespace tumble::frequency_response {

/// [s] first and last sample of the tone, and whether that is less than all samples.
struct Extent {
  double begin = 0.0, end = 0.0;
  bool cut = false;
};

/// Given: frequency [Hz]. The tone of the middle half, followed to both sides as long as the samples are on it: marks that are late or early leave a part
/// of the tone before or behind. All samples where the middle half is no tone.
Extent extent_of(const Samples& reference, double frequency);

}  // namespace tumble::frequency_response
