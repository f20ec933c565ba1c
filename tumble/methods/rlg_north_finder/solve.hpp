#pragma once

#include <vector>

#include "tumble/methods/rlg_north_finder/outputs.hpp"
#include "tumble/reduce/linear/joint.hpp"

/// From the coefficients of the linear models to the parameters of the north finder.
namespace tumble::rlg_north_finder {

/// Parameters in the order of wanted() with these values [SI], degrees of freedom and sources of uncertainty; sources
/// below a hundredth of every standard deviation share a line of the budget.
Estimate estimate_from(const std::vector<double>& values, const std::vector<double>& freedom,
                       const std::vector<SourceCovariance>& sources);

/// Degrees of freedom [1] of coefficient `index` alone.
double freedom_of(const MixedFit& fit, std::size_t index);

/// Scale factors, and the other coefficients over them. Throws Error::bad_data where the test does not show one.
Estimate least_squares_estimate(const linear::JointSolution& solution);

}  // namespace tumble::rlg_north_finder
