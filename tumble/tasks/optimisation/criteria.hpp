#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"

namespace tumble::optimisation {

/// How well an estimate knows the terms, relative to a reference sd of each. All are like a ratio of sds: the smaller
/// the better; +inf where a term is not determined.
struct Criteria {
  std::vector<double> sd;    ///< [SI] of each term; +inf: not determined
  double determinant = 0.0;  ///< geometric mean over the axes of the uncertainty ellipsoid: det^(1/2p)
  double trace = 0.0;        ///< root mean square of sd/reference
  double worst = 0.0;        ///< largest of them
};

/// With the plan's prior where it has one.
const Estimate& with_prior_if_any(const Estimate& estimate);

/// Standard uncertainty [SI] of each term; +inf where the estimate does not have it.
std::vector<double> sds_of(const Estimate& estimate, const std::vector<std::string>& terms);
/// Given: reference sd of each term [SI].
Criteria criteria_of(const Estimate& estimate, const std::vector<std::string>& terms,
                     const std::vector<double>& reference);

/// A reference sd [SI] of each term from the plan's limits: half the width, or the distance of one bound from the true
/// value; 0 without a limit.
std::vector<double> limit_widths(const Plan& plan, const Estimate& truth, const std::vector<std::string>& terms);

}  // namespace tumble::optimisation
