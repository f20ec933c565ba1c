#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/math/random.hpp"

namespace tumble::testing {

/// A simulated model: units with three parameters K0 [ug], K1 [ppm] and K2 [ug/g^2], whose results share the level of
/// the rig and the gravity of the site.
struct FleetModel {
  double spread = 1.0;       ///< tau of K0 and K1 over the private uncertainty of a result [1]; K2 has a third of it
  double correlation = 0.5;  ///< of K0 and K1 [1]
  double shared = 0.5;       ///< sd of the errors of a rig, over the private uncertainty [1]
  double outside = 0.0;      ///< distance of the unit from the mean of all, in spreads [1]
};

/// A result of a unit, and what is true of it [SI].
struct FleetResult {
  Estimate estimate;
  std::vector<double> truth;
};

/// Unit number `unit` tested on a rig. `shows`: all three parameters, "no K2", or "K0 with K2", where K0 contains 0.5
/// K2.
FleetResult fleet_result(const FleetModel& model, const RandomStream& random, std::uint64_t unit, std::uint64_t rig,
                         const std::string& shows = "all");

/// `count` results, the units on two rigs in turn.
std::vector<FleetResult> fleet_results(const FleetModel& model, const RandomStream& random, std::uint64_t count);

/// An estimate of one parameter "bias" [deg/h] with a private line of this sd, and of rig errors with a key of this sd.
Estimate single_result(double value, double sd, const std::string& rig = {}, double rig_sd = 0.0);

}  // namespace tumble::testing
