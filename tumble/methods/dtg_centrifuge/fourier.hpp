#pragma once

#include <vector>

#include "tumble/methods/dtg_centrifuge/reduce.hpp"

namespace tumble::dtg_centrifuge {

/// The source's estimator of one level: static means subtracted, output less reference, whole periods, first harmonic,
/// docs/equations (1.6)-(1.10). The scatter of the parts is that of the regression of the same difference.
Observation fourier_observation(const Test& test, const Measured& measured, const Reduction& reduction,
                                std::size_t index, const Relation& plain);

}  // namespace tumble::dtg_centrifuge
