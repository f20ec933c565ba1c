#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/methods/imu_channel_calibration/calibration.hpp"

namespace tumble::imu_channel_calibration {

/// One kind of sensor, calibrated both ways.
struct Pair {
  Kind kind = Kind::accelerometer;
  Calibration whole, split;
  double repeatability = 0.0;  ///< [SI] sd of a bias from power-up to power-up, as the differences show it
};

/// Parameters of both and their differences; errors of one key (gravity of one site, one rig) are common to both. A bias is
/// that of one power-up: the differences d_i of the three channels, of variance v_i, show how well it repeats,
/// s^2 = sum (d_i^2 - v_i)/6, which is in the uncertainty of both.
void add_parameters(std::vector<Pair>& pairs, Estimate& estimate);

/// A finding for each term that differs by more than twice the standard uncertainty and the tolerance, and the number
/// of those that agree. The repeatability of a bias is no part of this uncertainty: it is from these differences.
void add_agreement(const std::vector<Pair>& pairs, const Settings& settings, Estimate& estimate);

/// Table `comparison`, and curves: residuals of each channel in the positions for the check after compensation by each
/// calibration.
void add_comparison(const std::vector<Pair>& pairs, const Sorted& sorted, Estimate& estimate);

/// Table `terms`: whole, split and difference side by side.
Table side_by_side(const std::vector<Pair>& pairs, const Estimate& estimate);

/// (3.4) of the calibrations of the whole unit, for channels as those of its recordings.
std::vector<OutputModel> models_of(const std::vector<Pair>& pairs, const Evidence& whole, const Estimate& estimate);

}  // namespace tumble::imu_channel_calibration
