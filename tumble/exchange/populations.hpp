#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tumble/core/estimate.hpp"

/// Populations: mean and spread of a model from the results of many units.
namespace tumble {

/// The result of one unit.
struct TestedUnit {
  std::string serial, sha256;
  bool simulated = false;
  Estimate estimate;
};

/// A result that does not count, and why: a key in [population] of text/en.toml.
struct ResultLeftOut {
  std::string serial, sha256, why;
};

/// Why a result cannot be part of a population, as a key of [population]; empty: it can.
std::string unfit_for_population(const Estimate& estimate);

/// The population of a model: mean and covariance of a further unit, as an estimate with `population`.
///
/// The covariance is that of a unit that was not tested yet: "unit to unit" (8.33), what is not known of the means, and
/// with their keys the errors that the means share with the results they were made from. Parameters that five units
/// show by themselves are part of it; the others are named. Units that do not belong to the others (8.29) are listed
/// and not used. Simulated results are not mixed with measured ones.
///
/// Given     units  one result of each, of one model and method; `left_out`: results that were not taken, for the table
/// Throws    Error::bad_data with all that is missing: fewer than five units, no parameter that five units show
/// See       docs/equations (8.10), (8.11), (8.33)
Estimate population_of_units(const std::string& model, const std::string& method, std::vector<TestedUnit> units,
                             std::vector<ResultLeftOut> left_out = {});

/// A result of a unit on an occasion. `day`: "2026-11-20", empty where it is not known; `rig`: equipment, station or
/// kind of the rig, empty where it is not known.
struct OccasionResult {
  std::string serial, sha256, day, rig;
  double moment = 0.0;  ///< [s] since 1970
  Estimate estimate;
};

/// Components of variance of one parameter: unit to unit, rig to rig, day to day and turn-on to turn-on, each with its
/// interval, as an estimate of the method "components" with the parameters NAME_mean, NAME_unit_sd, NAME_rig_sd,
/// NAME_day_sd and NAME_turn_on_sd. What the results cannot separate is one component of both, and a finding says so.
///
/// Given     results  of one model and method
/// Throws    Error::bad_data for fewer than four results or three units with the parameter
/// See       docs/equations (8.7)-(8.9)
Estimate components_of_results(const std::string& model, const std::string& parameter,
                               std::vector<OccasionResult> results, std::vector<ResultLeftOut> left_out = {});

}  // namespace tumble
