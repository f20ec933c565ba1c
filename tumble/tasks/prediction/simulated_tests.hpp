#pragma once

#include <cstdint>

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"

namespace tumble::prediction {

/// The prediction for a method that has none of its own: what it states of simulated tests of the plan.
///
/// Each test is simulated with its own noise, rig errors and turn-on, and identified as a recording is. The covariance
/// is the mean of those that the method states, line by line of the budget, with the variance of each parameter scaled
/// to what its values scatter by; values are means, or those of [truth], degrees of freedom medians. Where
/// the method chooses what it estimates by the data, the parameters are those of most tests.
///
/// Given     plan  whose method identifies; with its calibration read. Recordings that have plans of their own are
///                 simulated by these
/// Throws    Error::bad_input where most tests are refused, with the reason of the first, or where one is too large
Estimate predict_by_tests(const Plan& plan);

/// One of these tests, without limits and prior. Throws as identify() does, and simulate().
Estimate simulated_test(const Plan& plan, std::uint64_t seed);

}  // namespace tumble::prediction
