#pragma once

#include "tumble/methods/testing/trials.hpp"

namespace tumble::gyro_scale_factor {

/// A gyro with a voltage output, an asymmetry and a cubic, on a rate table: 13 rates up and down again.
Trial trial(std::uint64_t seed, const std::vector<Option>& options);

/// All signs turned about, the senses in pairs without a rest, in the southern hemisphere, one sample of 19 missing,
/// and a clock that does not begin at zero.
Trial second_trial(std::uint64_t seed, const std::vector<Option>& options);

}  // namespace tumble::gyro_scale_factor
