#pragma once

#include "tumble/methods/testing/trials.hpp"

namespace tumble::dtg_centrifuge {

/// Five levels to 20 g in four power-ups, a minute each, with noise, all errors of the rig, a reference gyro of another
/// gain and azimuth, and drift that changes from power-up to power-up.
Trial trial(std::uint64_t seed, const std::vector<Option>& options);

/// As Method::second_trial.
Trial second_trial(std::uint64_t seed, const std::vector<Option>& options);

}  // namespace tumble::dtg_centrifuge
