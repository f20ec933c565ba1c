#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/math/matrix.hpp"
#include "tumble/methods/allan_noise/describe.hpp"

namespace tumble::allan_noise {

/// How a record follows the temperature beside it, and the course that this gives.
struct TemperatureCourse {
  TemperatureEffect effect;
  Matrix columns;  ///< temperature and its rate of change for each average; without the rate where it is noise
  std::vector<double> of_bias;  ///< [u] the effect at each sample
};

/// Fit of averages on the temperature and its rate of change beside the noise, see fit_courses. The averages are as
/// short as the noise of the thermometer allows: noise of a column makes its size too small.
/// Nothing where the temperature does not move by more than that noise.
/// Given: values [u], temperature [K], of the same samples; channel, with the noise found in them.
std::optional<TemperatureCourse> temperature_course(std::span<const double> values, std::span<const double> temperature,
                                                    const ChannelNoise& channel);

/// The thermometer of a recording that is sampled with a channel; null: none.
const Channel* temperature_of(const Recording& recording, const Channel& beside);

/// That the output follows the temperature, and that this was subtracted.
Finding follows_temperature(const ChannelNoise& channel);

/// Table `temperature`, of the channels beside which a temperature moved.
void describe_temperature(const std::vector<ChannelNoise>& channels, Estimate& estimate);

}  // namespace tumble::allan_noise
