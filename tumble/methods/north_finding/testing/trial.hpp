#pragma once

#include <cstdint>

#include "tumble/methods/testing/trials.hpp"

namespace tumble::north_finding {

Trial trial(std::uint64_t seed);

/// The other way round: a southern site with an uncertain latitude, another azimuth and tilt, parameters of the other
/// sign, no calibration but what the settings state, a table that a hand sets and whose angles are recorded, samples
/// lost.
Trial second_trial(std::uint64_t seed);

}  // namespace tumble::north_finding
