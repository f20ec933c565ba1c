#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/allan_noise/describe.hpp"

namespace tumble::allan_noise {

/// Readings of straight lines at each channel's Allan curve, beside the identified terms.
Table readings_table(const std::vector<ChannelNoise>& channels);

/// White noise and random walk as configuration files of visual-inertial estimators want them: continuous density and
/// random walk in SI, beside the standard deviation of one sample that they are not.
Table densities_table(const std::vector<ChannelNoise>& channels);

/// The sets of terms that were compared.
Table composites_table(const std::vector<ChannelNoise>& channels);

/// Length of record for a wanted relative uncertainty [1] of each term.
Table advice_table(const std::vector<ChannelNoise>& channels, double wanted);

}  // namespace tumble::allan_noise
