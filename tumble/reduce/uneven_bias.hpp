#pragma once

#include <string>

#include "tumble/core/finding.hpp"
#include "tumble/math/noise/noise_bands.hpp"

namespace tumble {

/// Findings where slow noise is not the same all along: the bias jumps (steps, popcorn noise), or it moves more in the
/// first eighth of the record than later (settling after power-up). Differences of neighbouring means, whose length is
/// doubled from 16 samples on, are compared with their median size, and those of the first eighth with the others.
///
/// Given: begin [s] of the record, rate [Hz]; unit in which the size of a jump is shown
Findings uneven_bias(const NoiseBands& bands, double begin, double rate, const std::string& unit_shown,
                     const std::string& label);

}  // namespace tumble
