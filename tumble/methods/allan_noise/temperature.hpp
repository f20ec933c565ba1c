#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/reduce/even_signal.hpp"

namespace tumble::allan_noise {

/// How a channel follows the temperature of its recording.
struct TemperatureEffect {
  double range = 0.0;                      ///< [K] of the averages
  double slope = 0.0, slope_sd = 0.0;      ///< [u/K]
  double of_rate = 0.0, of_rate_sd = 0.0;  ///< [u s/K] by the rate of change of the temperature
  double explained = 0.0;                  ///< share of the variance of the averages
  double average = 0.0;                    ///< [s] averaged over
  double chance = 1.0;                     ///< probability of so much of both without an effect
};

/// Regression of at most 64 averages on the temperature and its rate of change, by generalised least squares under the
/// noise that `channel` was found to have, a random walk at its limit where none was seen. The effect itself is part of
/// that noise, so its uncertainty is rather too large. Nothing where the temperature hardly moves. Few averages: noise
/// of the temperature would make the slope by its rate of change too small.
/// Given: values [u], temperature [K], of the same samples.
std::optional<TemperatureEffect> temperature_effect(std::span<const double> values, std::span<const double> temperature,
                                                    const ChannelNoise& channel);

/// Table `temperature` and findings, where a recording has a channel of temperature.
void describe_temperature(const Evidence& evidence, const std::vector<ChannelRun>& stretches,
                          const std::vector<ChannelNoise>& channels, Estimate& estimate);

}  // namespace tumble::allan_noise
