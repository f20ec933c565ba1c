#pragma once

#include <string>

#include "tumble/reduce/even_signal.hpp"

namespace tumble {

/// Treats zeros as missing that are no values of the output: ten and more samples are exactly zero, though values as near
/// to zero as a fiftieth of the noise of a sample occur (so that it has no steps and no dead band), or though all others
/// are five times that noise away from zero. Drivers write zero where they have no sample. Zeros that alternate with the
/// samples of a slower sensor are removed, and the rate is that of the others.
/// Returned: a finding, or nothing.
Findings take_zeros_out(EvenSignal& signal, const std::string& label);

}  // namespace tumble
