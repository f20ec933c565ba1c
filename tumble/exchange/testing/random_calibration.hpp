#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tumble/exchange/calibration.hpp"

/// Calibrations and inputs drawn at random, for the tests of exports.
namespace tumble::testing {

/// Parts that a random calibration has.
struct Parts {
  bool scale = true, misalignment = true, bias = true, by_force = true;
  bool curve = false, lever = false, table = false, thermal_bias = false, thermal_scale = false, noise = true;
};

/// Scale factors and misalignments of up to 5 %, biases of up to 0.5 m/s^2 and 0.02 rad/s, G of up to 1e-3 s/m.
ImuCalibration random_calibration(std::uint64_t seed, const Parts& parts);

/// Inputs [SI] of up to 2 g, 4 rad/s, 10 rad/s^2, from -10 to 50 degC.
ImuSample random_truth(std::uint64_t seed);

/// Greatest difference of forces and rates [SI].
double difference(const ImuSample& a, const ImuSample& b);

}  // namespace tumble::testing
